"""Fronts of several costs on the made-up city: a second search over the written files finds the same points."""

from __future__ import annotations

import heapq
from pathlib import Path

from experiments.benchmark.road_costs import COSTS, problem_between, random_queries, write_files
from experiments.benchmark.road_network import road_network
from prefplan import pareto_front

Costs = tuple[int, ...]


def test_the_points_are_those_of_a_search_over_the_files(tmp_path: Path) -> None:
    roads = road_network(25, 25)
    write_files(roads, tmp_path)
    files = [(tmp_path / f"{name}.gr").read_text().splitlines()[2:] for name in COSTS]
    arcs = [[tuple(map(int, line.split()[1:])) for line in file] for file in files]
    ends = [[arc[:2] for arc in column] for column in arcs]
    assert ends[0] == ends[1] == ends[2] and len(set(ends[0])) == len(ends[0])
    several = {pair: tuple(column[k][2] for column in arcs) for k, pair in enumerate(ends[0])}
    queries = random_queries(roads, (12, 9))
    assert len(queries) == 2
    for query in queries:
        for count in (2, 3):
            front = pareto_front(problem_between(tmp_path, COSTS[:count], query))
            fewer = {pair: costs[:count] for pair, costs in several.items()}
            assert [tuple(plan.costs.values()) for plan in front] == points_by_comparison(fewer, *query, count)


def points_by_comparison(costs: dict[tuple[int, ...], Costs], source: int, target: int, count: int) -> list[Costs]:
    """Return the front of any number of costs by comparing each path with all others to the same node."""
    kept: dict[int, list[Costs]] = {}
    frontier = [((0,) * count, source)]
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
