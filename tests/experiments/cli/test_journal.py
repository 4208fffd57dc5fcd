"""Journals: no finished result is lost, and results of different experiments are not mixed."""

from __future__ import annotations

from pathlib import Path

import pytest

from experiments.cli.journal import Journal
from prefplan.errors import PrefplanError

HEADER: dict[str, object] = {"prefplan": "1", "scenario": "cup", "seed": 3, "actions": ["grasp cup"]}


def opened(path: Path, header: dict[str, object] = HEADER) -> Journal:
    return Journal(path, header, key="rollout")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A file with two records."""
    path = tmp_path / "rollouts.jsonl"
    records = opened(path)
    records.add({"rollout": 4, "completed": True})
    records.add({"rollout": 2, "completed": False})
    return path


def test_what_was_added_is_there_again(path: Path) -> None:
    assert opened(path).done == {4: {"rollout": 4, "completed": True}, 2: {"rollout": 2, "completed": False}}


def test_wherever_a_write_was_cut_off_the_whole_lines_before_it_count(path: Path) -> None:
    content = path.read_bytes()
    lines = [i + 1 for i, byte in enumerate(content) if byte == ord("\n")]
    for cut in range(len(content)):
        path.write_bytes(content[:cut])
        records = opened(path)
        assert len(records.done) == max(0, sum(line <= cut for line in lines) - 1)
        records.add({"rollout": 9})
        assert 9 in opened(path).done


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seed": 4}, r"rollouts.jsonl: holds another experiment \(seed 3, not 4\); give another --out"),
        ({"actions": []}, r"\(actions \['grasp cup'\], not \[\]\)"),
        ({"faults": "random"}, "faults None, not 'random'"),
    ],
)
def test_another_experiment_is_not_mixed_in(path: Path, change: dict[str, object], message: str) -> None:
    before = path.read_bytes()
    with pytest.raises(PrefplanError, match=message):
        opened(path, HEADER | change)
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (b"[]", "line 4: not the result of a rollout; the file is damaged"),
        (b"{]", "line 4: not the result of a rollout; the file is damaged"),
        (b"{}", "line 4: not the result of a rollout"),
    ],
)
def test_damage_is_told_and_left_alone(path: Path, line: bytes, message: str) -> None:
    path.write_bytes(path.read_bytes() + line + b"\n")
    with pytest.raises(PrefplanError, match=message):
        opened(path)


def test_a_file_of_something_else_is_told(tmp_path: Path) -> None:
    path = tmp_path / "rollouts.jsonl"
    path.write_text('{"a": "b"}\n')
    with pytest.raises(PrefplanError, match="line 1: not the header"):
        opened(path)
