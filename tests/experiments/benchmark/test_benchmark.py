"""The benchmark of the paper's Table I, on its smallest instances."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from statistics import fmean, median
from typing import Any

import pytest

from experiments.benchmark import __main__ as program
from experiments.benchmark import groups
from experiments.benchmark.instances import FAMILIES, PAPER, RANDOM, instance
from experiments.benchmark.large_models import Size
from experiments.benchmark.runs import BARE, KINDS, MAX_MIN, OURS, Record, Search, run_search
from experiments.benchmark.summary import cells, disagreements, tables


def record(method: str, seed: int, seconds: float, *, ended: str | None = None, points: Any = ((3.0, 1.0),)) -> Record:
    what = {"family": PAPER, "kind": "front", "tasks": 4, "method": method, "seed": seed}
    memory = {"peak_bytes": 1_000_000, "baseline_bytes": 100_000_000}
    found = {"points": None, "within": None} if ended else {"points": points, "within": 0}
    return what | memory | found | {"seconds": seconds, "expanded": 10, "ended": ended}


def test_table_1_has_a_row_for_each_family_kind_and_method_beside_records_and_picture(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert program.main(["table1", "--tasks", "2", "--seeds", "1", "--out", str(tmp_path)]) == 0
    header, *records = map(json.loads, (tmp_path / "table1.jsonl").read_text().splitlines())
    assert {"prefplan", "cpu", "cores", "python", "numba", "seeds", "tasks"} == set(header)
    methods = (OURS, MAX_MIN, BARE)
    places = [(run["family"], run["kind"], run["tasks"], run["method"]) for run in records]
    assert sorted(places) == sorted((family, kind, 2, m) for family in FAMILIES for kind in KINDS for m in methods)
    for cell in cells(records):
        (run,) = cell.runs.values()
        assert run["ended"] is None and run["seconds"] > 0 and run["expanded"] > 0 and run["baseline_bytes"] > 0
        assert (cell.statistic("ratio", median) is None) == (cell.what["method"] == OURS)
    printed = capsys.readouterr().out
    assert printed.count("## ") == len(FAMILIES) * len(KINDS) and printed == tables(cells(records)) + "\n\n"
    assert [line.split("|")[3].strip() for line in table_rows(printed)[:3]] == ["", "0.0075", "0.0388"]
    assert (tmp_path / "table1.png").read_bytes().startswith(b"\x89PNG")


def table_rows(printed: str) -> list[str]:
    """Return the lines of tables, without headings."""
    return [
        line for line in printed.splitlines() if line.startswith("|") and "method" not in line and "---" not in line
    ]


def test_an_interrupted_benchmark_goes_on_where_it_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runs = [run for run in groups.table1(1) if run.what["tasks"] == 2]
    assert len(runs) > 3
    carried_out: list[Search] = []

    def interrupted_at(count: int) -> Callable[[Search], Record]:
        def run_search(run: Search) -> Record:
            if len(carried_out) == count:
                raise KeyboardInterrupt
            carried_out.append(run)
            return record(OURS, 0, 1) | run.what

        return run_search

    monkeypatch.setattr(program, "run_search", interrupted_at(3))
    with pytest.raises(KeyboardInterrupt):
        program.run_searches(runs, tmp_path / "runs.jsonl")
    monkeypatch.setattr(program, "run_search", interrupted_at(-1))
    results = program.run_searches(runs, tmp_path / "runs.jsonl")
    assert carried_out == runs
    assert [{**run.what} for run in runs] == [{name: found[name] for name in runs[0].what} for found in results]


@pytest.mark.parametrize("kind", KINDS)
def test_a_run_ends_at_its_time_limit(kind: str) -> None:
    ended = run_search(Search({"kind": kind, "method": OURS}, partial(instance, RANDOM, 12, 0), max_seconds=0.3))
    assert ended["ended"] == "time" and ended["points"] is None


def test_what_was_ended_counts_as_a_lower_bound() -> None:
    ours = [record(OURS, seed, seconds) for seed, seconds in enumerate((1, 2, 4))]
    yardstick = [record(MAX_MIN, 0, 3), record(MAX_MIN, 1, 5), record(MAX_MIN, 2, 120, ended="time")]
    cell = next(cell for cell in cells(ours + yardstick) if cell.what["method"] == MAX_MIN)
    assert (cell.statistic("seconds", median), cell.statistic("seconds", max)) == ((5, False), (120, True))
    assert (cell.statistic("seconds", fmean), cell.statistic("seconds", min)) == ((128 / 3, True), (3, False))
    assert (cell.statistic("ratio", median), cell.statistic("ratio", max)) == ((3, False), (30, True))
    half = [record(OURS, 0, 3), record(OURS, 1, 150, ended="time")]
    assert cells(half)[0].statistic("seconds", median) == (76.5, True)


def test_methods_that_disagree_are_found() -> None:
    ours = record(OURS, 0, 1)
    assert len(disagreements([ours, record(MAX_MIN, 0, 1, points=((3.0, 2.0),))])) == 1
    assert not disagreements([ours, record(MAX_MIN, 0, 1, ended="time")])


def test_each_search_of_a_group_of_cases_gets_a_row(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes = {"few": Size(3, ((0, 2), (1,))), "more": Size(4, ((0, 2), (1,)))}
    monkeypatch.setitem(groups.GROUPS, "large", partial(groups.large, sizes))
    monkeypatch.setattr(program, "warm_up", lambda: None)  # as Table I does above; it takes two seconds
    monkeypatch.setattr(program, "wrong_fronts", list)
    assert program.main(["large", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert [line[3:] for line in printed.splitlines() if line.startswith("## ")] == [*KINDS]
    rows = [[cell.strip() for cell in line.split("|")[1:3]] for line in table_rows(printed)]
    assert rows == [[name, OURS] for _ in KINDS for name in sizes]


def test_a_wrong_front_is_not_timed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(program, "wrong_fronts", lambda: ["58 07 99: found nothing"])
    assert program.main(["table1", "--tasks", "2", "--seeds", "1", "--out", str(tmp_path)]) == program.WRONG
    said = capsys.readouterr()
    assert said.out == "" and "58 07 99" in said.err
    assert not list(tmp_path.iterdir())


def test_orderings_of_the_papers_formulas_nest() -> None:
    small, large = instance(PAPER, 3, 7), instance(PAPER, 6, 7)
    assert [task.formula for task in large.tasks][:3] == [task.formula for task in small.tasks]
