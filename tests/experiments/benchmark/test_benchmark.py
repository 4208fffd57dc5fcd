"""The benchmark of the paper's Table I, on its smallest instances."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from experiments.benchmark import table1
from experiments.benchmark.instances import FAMILIES, PAPER, RANDOM, instance
from experiments.benchmark.runs import KINDS, MAX_MIN, OURS, BenchmarkRun, Timing, carry_out
from experiments.benchmark.summary import cells, disagreements


def outcome(seconds: float, *, ended: str | None = None, points: Any = ((3.0, 1.0),)) -> Timing:
    return Timing(seconds, 10, 1_000_000, 100_000_000, None if ended else points, ended)


def front_runs(method: str, *outcomes: Timing) -> dict[BenchmarkRun, Timing]:
    return {BenchmarkRun(PAPER, "front", method, 4, seed, 120): timing for seed, timing in enumerate(outcomes)}


def test_the_json_has_a_cell_for_each_family_kind_and_method_beside_table_and_picture(tmp_path: Path) -> None:
    assert table1.main(["--tasks", "2", "--seeds", "1", "--out", str(tmp_path)]) == 0
    report = json.loads((tmp_path / "table1.json").read_text())
    assert set(report) == {"about", "notes", "date", "machine", "limits", "cells", "runs"}
    assert report["notes"][-1].startswith("Instances of each size: 1 for ours")
    assert {"cpu", "cores", "python", "numba"} <= set(report["machine"])
    methods = (OURS, MAX_MIN, "no heuristic")
    places = [(cell["family"], cell["kind"], cell["tasks"], cell["method"]) for cell in report["cells"]]
    assert sorted(places) == sorted((family, kind, 2, m) for family in FAMILIES for kind in KINDS for m in methods)
    assert len(report["runs"]) == len(places)
    for cell in report["cells"]:
        assert cell["runs"] == 1 and cell["ended"] == []
        assert cell["seconds"]["median"] > 0 and cell["expanded"]["max"] > 0 and cell["baseline_mb"] > 0
        assert (cell["ratio_to_ours"] is None) == (cell["method"] == OURS)
    assert (tmp_path / "table1.md").read_text().count("## ") == len(FAMILIES) * len(KINDS)
    assert (tmp_path / "table1.png").read_bytes().startswith(b"\x89PNG")
    assert not list(tmp_path.glob("*.jsonl"))


def test_an_interrupted_benchmark_goes_on_where_it_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runs = table1.plan_runs(range(2, 3), 1)
    assert len(runs) > 3
    carried_out: list[BenchmarkRun] = []

    def interrupted_at(count: int) -> Callable[[BenchmarkRun], Timing]:
        def carry_out(run: BenchmarkRun) -> Timing:
            if len(carried_out) == count:
                raise KeyboardInterrupt
            carried_out.append(run)
            return outcome(1)

        return carry_out

    monkeypatch.setattr(table1, "carry_out", interrupted_at(3))
    with pytest.raises(KeyboardInterrupt):
        table1.carry_out_all(runs, tmp_path / "runs.jsonl")
    monkeypatch.setattr(table1, "carry_out", interrupted_at(-1))
    results = table1.carry_out_all(runs, tmp_path / "runs.jsonl")
    assert carried_out == runs
    assert list(results) == runs


@pytest.mark.parametrize("kind", KINDS)
def test_a_run_ends_at_its_time_limit(kind: str) -> None:
    ended = carry_out(BenchmarkRun(RANDOM, kind, OURS, 12, 0, max_seconds=0.3))
    assert ended.ended == "time" and ended.points is None


def test_what_was_ended_counts_as_a_lower_bound() -> None:
    ours = front_runs(OURS, outcome(1), outcome(2), outcome(4))
    yardstick = front_runs(MAX_MIN, outcome(3), outcome(5), outcome(120, ended="time"))
    cell = next(cell for cell in cells(ours | yardstick) if cell["method"] == MAX_MIN)
    assert (cell["seconds"]["median"], cell["seconds"]["max"]) == (5, 120)
    assert set(cell["seconds"]["at_least"]) == {"mean", "max"}
    assert (cell["ratio_to_ours"]["median"], cell["ratio_to_ours"]["max"]) == (3, 30)
    assert cell["ended"] == ["time"]
    half = front_runs(OURS, outcome(3), outcome(150, ended="time"))
    assert "median" in cells(half)[0]["seconds"]["at_least"]


def test_methods_that_disagree_are_found() -> None:
    ours = front_runs(OURS, outcome(1))
    other = front_runs(MAX_MIN, outcome(1, points=((3.0, 2.0),)))
    assert len(disagreements(ours | other)) == 1
    assert not disagreements(ours | front_runs(MAX_MIN, outcome(1, ended="time")))


def test_a_wrong_front_is_not_timed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(table1, "wrong_fronts", lambda: ["58 07 99: found nothing"])
    assert table1.main(["--tasks", "2", "--seeds", "1", "--out", str(tmp_path)]) == table1.WRONG
    said = capsys.readouterr()
    assert said.out == "" and "58 07 99" in said.err
    assert not list(tmp_path.iterdir())


def test_orderings_of_the_papers_formulas_nest() -> None:
    small, large = instance(PAPER, 3, 7), instance(PAPER, 6, 7)
    assert [task.formula for task in large.tasks][:3] == [task.formula for task in small.tasks]
