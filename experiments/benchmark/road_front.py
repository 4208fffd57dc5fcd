"""Fronts of two costs on published road networks: number of points and planning time.

The networks are those of Raith and Ehrgott, "A comparison of solution strategies for biobjective shortest path
problems" (2009): a line `sp min NODES ARCS`, lines of a source and a target, and a line `FROM TO COST COST` for each
arc. A second file has the queries: two lines, `FROM 1` and `TO -1`, for each.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Sequence
from heapq import heappop, heappush
from math import inf
from pathlib import Path
from typing import NamedTuple

from prefplan import Planner, Problem, Task
from prefplan.models.graph_file import GraphFileModel

NETWORK, QUERIES = "DC1", "DC_ODpairs.txt"
"""Files of the network and of its queries."""

COSTS = ("first", "second")
"""The two costs, in the order of the file."""

Arc = tuple[int, int, int, int]
"""From, to, and the two costs."""

CostPair = tuple[int, int]


class Query(NamedTuple):
    """A path query: source and target nodes."""

    source: int
    target: int


def main() -> None:
    """Print a row of a table for each query, and check its front by a second, independent search."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help=f"with the files {NETWORK} and {QUERIES}")
    source = parser.parse_args().folder
    for name in (NETWORK, QUERIES):
        if not (source / name).is_file():
            parser.error(f"folder: {source} has no file {name}")
    arcs, queries = read_arcs(source / NETWORK), read_queries(source / QUERIES)
    print("| query | points | labels expanded | read, CPU s | front, CPU s |\n| --- | --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        write_dimacs(arcs, Path(folder))
        for query in queries:
            began = time.process_time()
            problem = problem_between(Path(folder), COSTS, query)
            read = time.process_time()
            front = Planner(problem).front()
            planned = time.process_time()
            row = f"{query.source} to {query.target} | {len(front)} | {front.stats.expanded}"
            print(f"| {row} | {read - began:.2f} | {planned - read:.2f} |", flush=True)
            expected = points_by_one_search(arcs, query)
            if [tuple(plan.objectives.values()) for plan in front] != expected:
                sys.exit(f"another search finds {expected}")


def read_arcs(file: Path) -> list[Arc]:
    """Return the arcs of a network."""
    lines = [line.split() for line in file.read_text().splitlines()]
    return [(int(a), int(b), int(c), int(d)) for a, b, c, d in (line for line in lines[1:] if len(line) == 4)]


def read_queries(file: Path) -> list[Query]:
    """Return the queries of a file."""
    nodes = [int(line.split()[0]) for line in file.read_text().splitlines() if line.strip()]
    return [Query(*ends) for ends in zip(nodes[::2], nodes[1::2], strict=True)]


def write_dimacs(arcs: list[Arc], folder: Path) -> None:
    """Write a DIMACS file of each cost."""
    nodes = max(max(arc[:2]) for arc in arcs)
    for k, name in enumerate(COSTS, start=2):
        lines = "".join(f"a {arc[0]} {arc[1]} {arc[k]}\n" for arc in arcs)
        (folder / f"{name}.gr").write_text(f"p sp {nodes} {len(arcs)}\n{lines}")


def problem_between(folder: Path, costs: Sequence[str], query: Query) -> Problem:
    """Return a query as a problem without preferences: one task, to reach the target; each cost has a file."""
    files = {name: f"{name}.gr" for name in costs}
    model = GraphFileModel(folder, files, query.source, labels={str(query.target): ["goal"]})
    return Problem(model.transition_system(), [Task("arrive", "F goal")], [])


def points_by_one_search(arcs: list[Arc], query: Query) -> list[CostPair]:
    """Return the front of a query, by a search that keeps the least second cost at each node."""
    leaving: dict[int, list[tuple[int, int, int]]] = {}
    for source, target, first, second in arcs:
        leaving.setdefault(source, []).append((target, first, second))
    least: dict[int, float] = {}
    points: list[CostPair] = []
    frontier = [(0, 0, query.source)]
    while frontier:
        first, second, node = heappop(frontier)
        if second >= min(least.get(node, inf), least.get(query.target, inf)):
            continue
        least[node] = second
        if node == query.target:
            points.append((first, second))
        for target, more, also in leaving.get(node, ()):
            heappush(frontier, (first + more, second + also, target))
    return points


if __name__ == "__main__":
    main()
