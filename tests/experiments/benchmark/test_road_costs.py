"""Fronts of several costs on the made-up city: other searches over the files that are written find the same points."""

from __future__ import annotations

import heapq
import sys
from pathlib import Path

import pytest

from experiments.benchmark import road_costs
from experiments.benchmark.road_front import points_by_one_search, read_arcs


def test_the_points_are_those_of_searches_over_the_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["road_costs", str(tmp_path), *"--columns 25 --rows 25 --blocks 12 9".split()])
    road_costs.main()
    rows = capsys.readouterr().out.splitlines()[4:]
    files = [(tmp_path / f"{name}.gr").read_text().splitlines()[2:] for name in road_costs.COSTS]
    arcs = [[tuple(map(int, line.split()[1:])) for line in file] for file in files]
    ends = [[arc[:2] for arc in column] for column in arcs]
    assert ends[0] == ends[1] == ends[2] and len(set(ends[0])) == len(ends[0])
    several = {pair: tuple(column[k][2] for column in arcs) for k, pair in enumerate(ends[0])}
    two = read_arcs(tmp_path / "two_costs.txt")
    assert two == [(*pair, *costs[:2]) for pair, costs in several.items()]
    queries = [tuple(map(int, line.split())) for line in (tmp_path / "queries.txt").read_text().splitlines()]
    assert len(queries) == 2
    for source, target in queries:
        found = [points_of(tmp_path / f"{source}_{target}_{count}.txt") for count in (2, 3)]
        assert found[0] == points_by_one_search(two, road_costs.Query(source, target))
        assert found[1] == points_by_comparison(several, source, target)
        for points in found:
            assert any(row.startswith(f"| {source} to {target} | {len(points[0])} | {len(points)} |") for row in rows)


def points_of(file: Path) -> list[tuple[int, ...]]:
    """Return the points of a front."""
    return [tuple(map(int, line.split())) for line in file.read_text().splitlines()]


def points_by_comparison(
    costs: dict[tuple[int, ...], tuple[int, ...]], source: int, target: int
) -> list[tuple[int, ...]]:
    """Return the front of any number of costs by comparing each path with all others to where it leads."""
    kept: dict[int, list[tuple[int, ...]]] = {}
    frontier = [((0,) * 3, source)]
    while frontier:
        spent, place = heapq.heappop(frontier)
        known = kept.setdefault(place, [])
        if any(all(a <= b for a, b in zip(other, spent, strict=True)) for other in known):
            continue
        known.append(spent)
        for (begin, end), more in costs.items():
            if begin == place:
                heapq.heappush(frontier, (tuple(a + b for a, b in zip(spent, more, strict=True)), end))
    return kept[target]
