"""`experiments/fuzz.py`: judging goes on until it is told to end, and what differs is kept."""

from __future__ import annotations

import tomllib
from pathlib import Path

import judge.verdict
import pytest

from experiments import fuzz
from prefplan import load

Captured = pytest.CaptureFixture[str]


@pytest.fixture(autouse=True)
def in_an_empty_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)


def test_some_problems_are_judged_and_agree(capsys: Captured) -> None:
    assert fuzz.main(["--seconds", "2", "--seed", "7"]) == 0
    first, last = capsys.readouterr().out.splitlines()
    assert first == "seed 7"
    count, rest = last.split(" ", 1)
    assert int(count) > 0 and rest == "problems judged, 0 differ"


def test_a_problem_that_differs_is_saved_as_a_scenario(monkeypatch: pytest.MonkeyPatch, capsys: Captured) -> None:
    answers = iter([None, "front [(1, 2)],\nexpected []", AssertionError("plan is worth less")])

    def pretend(problem: object, ways: object) -> str | None:
        answer = next(answers, KeyboardInterrupt())
        if isinstance(answer, BaseException):
            raise answer
        return answer

    monkeypatch.setattr(judge.verdict, "verdict", pretend)
    assert fuzz.main(["--seed", "40"]) == 1
    assert capsys.readouterr().out.splitlines()[-1] == "3 problems judged, 2 differ"
    told = {41: ["# front [(1, 2)],", "# expected []"], 42: ["# AssertionError: plan is worth less"]}
    for number, remarks in told.items():
        file = fuzz.FOLDER / f"problem_{number}.toml"
        assert file.read_text().splitlines()[: len(remarks)] == remarks
        assert tomllib.loads(file.read_text()) == fuzz.draw(judge, number).scenario()
        assert load(file).problem().tasks
    assert len(list(fuzz.FOLDER.iterdir())) == 2


def test_ctrl_c_ends_it_with_the_count(monkeypatch: pytest.MonkeyPatch, capsys: Captured) -> None:
    calls = []

    def interrupted(problem: object, ways: object) -> None:
        calls.append(ways)
        if len(calls) == 7:
            raise KeyboardInterrupt

    monkeypatch.setattr(judge.verdict, "verdict", interrupted)
    assert fuzz.main(["--seed", "1"]) == 0
    captured = capsys.readouterr()
    assert captured.out.splitlines()[-1] == "6 problems judged, 0 differ"
    assert "Traceback" not in captured.err
    assert [len(ways) for ways in calls] == [5, 1, 1, 1, 1, 5, 1]


def test_without_the_tests_it_says_what_is_missing(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: Captured
) -> None:
    monkeypatch.setattr(fuzz, "TESTS", tmp_path)
    assert fuzz.main(["--seed", "1"]) == 2
    message = f"fuzz: {tmp_path / 'judge'} is missing: fuzzing needs a checkout of prefplan with its tests\n"
    assert capsys.readouterr().err == message


def test_a_time_that_is_none_is_refused(capsys: Captured) -> None:
    with pytest.raises(SystemExit):
        fuzz.main(["--seconds", "-1"])
    assert "--seconds: '-1' is not a number >= 0" in capsys.readouterr().err
