"""The benchmark of the paper's Table I, on its smallest instances."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from experiments.benchmark import cases, table1
from experiments.benchmark.instances import FAMILIES, PAPER, RANDOM, instance
from experiments.benchmark.large_models import Size
from experiments.benchmark.runs import BARE, KINDS, MAX_MIN, OURS, Record, Search, run_search, search
from experiments.benchmark.summary import cells, disagreements


def record(method: str, seed: int, seconds: float, *, ended: str | None = None, points: Any = ((3.0, 1.0),)) -> Record:
    what = {"family": PAPER, "kind": "front", "tasks": 4, "method": method, "seed": seed}
    memory = {"peak_bytes": 1_000_000, "baseline_bytes": 100_000_000}
    found = {"points": None, "within": None} if ended else {"points": points, "within": 0}
    return what | memory | found | {"seconds": seconds, "expanded": 10, "ended": ended}


def test_the_json_has_a_cell_for_each_family_kind_and_method_beside_table_and_picture(tmp_path: Path) -> None:
    assert table1.main(["--tasks", "2", "--seeds", "1", "--out", str(tmp_path)]) == 0
    report = json.loads((tmp_path / "table1.json").read_text())
    assert set(report) == {"about", "notes", "date", "machine", "limits", "cells"}
    assert report["notes"][-1].startswith("Instances of each size: 1 for ours")
    assert {"cpu", "cores", "python", "numba"} <= set(report["machine"])
    methods = (OURS, MAX_MIN, BARE)
    places = [(cell["family"], cell["kind"], cell["tasks"], cell["method"]) for cell in report["cells"]]
    assert sorted(places) == sorted((family, kind, 2, m) for family in FAMILIES for kind in KINDS for m in methods)
    assert len((tmp_path / "table1.runs.jsonl").read_text().splitlines()) == 1 + len(places)
    for cell in report["cells"]:
        assert cell["runs"] == 1 and cell["ended"] == []
        assert cell["seconds"]["median"] > 0 and cell["expanded"]["max"] > 0 and cell["baseline_mb"] > 0
        assert (cell["ratio"] is None) == (cell["method"] == OURS)
    assert (tmp_path / "table1.md").read_text().count("## ") == len(FAMILIES) * len(KINDS)
    assert (tmp_path / "table1.png").read_bytes().startswith(b"\x89PNG")


def test_an_interrupted_benchmark_goes_on_where_it_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runs = table1.plan_runs(range(2, 3), 1)
    assert len(runs) > 3
    carried_out: list[Search] = []

    def interrupted_at(count: int) -> Callable[[Search], Record]:
        def run_search(run: Search) -> Record:
            if len(carried_out) == count:
                raise KeyboardInterrupt
            carried_out.append(run)
            return record(OURS, 0, 1) | run.what

        return run_search

    monkeypatch.setattr(table1, "run_search", interrupted_at(3))
    with pytest.raises(KeyboardInterrupt):
        table1.run_searches(runs, tmp_path / "runs.jsonl")
    monkeypatch.setattr(table1, "run_search", interrupted_at(-1))
    results = table1.run_searches(runs, tmp_path / "runs.jsonl")
    assert carried_out == runs
    assert [{**run.what} for run in runs] == [{name: found[name] for name in runs[0].what} for found in results]


@pytest.mark.parametrize("kind", KINDS)
def test_a_run_ends_at_its_time_limit(kind: str) -> None:
    ended = run_search(Search({"seed": 0}, partial(instance, RANDOM, 12, 0), partial(search, kind, max_seconds=0.3)))
    assert ended["ended"] == "time" and ended["points"] is None


def test_what_was_ended_counts_as_a_lower_bound() -> None:
    ours = [record(OURS, seed, seconds) for seed, seconds in enumerate((1, 2, 4))]
    yardstick = [record(MAX_MIN, 0, 3), record(MAX_MIN, 1, 5), record(MAX_MIN, 2, 120, ended="time")]
    cell = next(cell for cell in cells(ours + yardstick) if cell["method"] == MAX_MIN)
    assert (cell["seconds"]["median"], cell["seconds"]["max"]) == (5, 120)
    assert set(cell["seconds"]["at_least"]) == {"mean", "max"}
    assert (cell["ratio"]["median"], cell["ratio"]["max"]) == (3, 30)
    assert cell["ended"] == ["time"]
    half = [record(OURS, 0, 3), record(OURS, 1, 150, ended="time")]
    assert "median" in cells(half)[0]["seconds"]["at_least"]


def test_methods_that_disagree_are_found() -> None:
    ours = record(OURS, 0, 1)
    assert len(disagreements([ours, record(MAX_MIN, 0, 1, points=((3.0, 2.0),))])) == 1
    assert not disagreements([ours, record(MAX_MIN, 0, 1, ended="time")])


def test_each_search_of_a_group_of_cases_gets_a_row(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes = {"few": Size(3, 3, ((0, 2), (1,))), "more": Size(4, 4, ((0, 2), (1,)))}
    monkeypatch.setitem(cases.GROUPS, "large", partial(cases.large, sizes))
    monkeypatch.setattr(cases, "warm_up", lambda: None)  # as Table I does above; it takes two seconds
    assert cases.main(["large"]) == 0
    rows = [line.split("|")[1:-1] for line in capsys.readouterr().out.splitlines() if line]
    assert [[cell.strip() for cell in row[:2]] for row in rows[2:]] == [
        [name, kind] for name in sizes for kind in KINDS
    ]


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
