"""Fronts of two and of three costs on the made-up city's roads, and files of both for other programs.

The costs of a road are the driving time, its length and how far it climbs. The folder gets a DIMACS file of each cost,
all with the same roads in the same order, and no two roads from one crossing to another; `two_costs.txt`, which begins
with the numbers of crossings and roads and has a line `FROM TO SECONDS METRES` for each road; `queries.txt`, a line
`FROM TO` for each query; and for each query and number of costs the points of the front, one a line.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from experiments.benchmark.road_front import Query, problem_between
from experiments.benchmark.road_network import BLOCK_M, COLUMNS, ROWS, Roads, arcs_text, road_network
from experiments.cli.files import make_folder
from prefplan import Planner

COSTS = ("seconds", "metres", "climb")
"""The costs, in the order in which they are compared; climbs are in decimetres."""

HILLS = ((30.0, 700.0), (10.0, 190.0))
"""Heights of hills and of bumps on them, and the lengths over which they rise and fall, m."""

BLOCKS = (40, 40, 80, 80, 120, 120)
"""How far apart the places of each query are, as the crow flies, in blocks."""


def main() -> None:
    """Write the files, and print a row of a table for each query and number of costs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="where to write the files")
    parser.add_argument("--columns", type=int, default=COLUMNS, help="crossings from west to east, see road_network")
    parser.add_argument("--rows", type=int, default=ROWS, help="crossings from south to north")
    parser.add_argument("--blocks", type=int, nargs="+", default=BLOCKS, help="how far apart the places of queries are")
    options = parser.parse_args()
    make_folder(options.folder)
    roads = road_network(options.columns, options.rows)
    queries = random_queries(roads, options.blocks)
    write_files(roads, queries, options.folder)
    print(f"{len(roads.points)} crossings, {len(roads.sources)} roads\n")
    print("| query | costs | points | labels expanded | front, CPU s |\n| --- | --- | --- | --- | --- |")
    for query in queries:
        for names in (COSTS[:2], COSTS):
            problem = problem_between(options.folder, {name: f"{name}.gr" for name in names}, query)
            began = time.process_time()
            front = Planner(problem).front()
            row = f"{query.source} to {query.target} | {len(names)} | {len(front)} | {front.stats.expanded}"
            print(f"| {row} | {time.process_time() - began:.2f} |", flush=True)
            points = "".join(f"{' '.join(map(str, plan.costs.values()))}\n" for plan in front)
            (options.folder / f"{query.source}_{query.target}_{len(names)}.txt").write_text(points)


def costs_of(roads: Roads) -> dict[str, np.ndarray]:
    """Return the (E,) int64 costs of the roads, by name."""
    ends = roads.points[roads.targets], roads.points[roads.sources]
    climb = 10 * (heights(ends[0]) - heights(ends[1])).clip(min=0)
    metres = np.hypot(*(ends[0] - ends[1]).T)
    columns = (roads.seconds, np.maximum(metres, 1), climb)
    return {name: np.rint(column).astype(np.int64) for name, column in zip(COSTS, columns, strict=True)}


def heights(points: np.ndarray) -> np.ndarray:
    """Return how high (S, 2) points lie, m."""
    waves = [height * np.sin(points[:, 0] / length) * np.cos(points[:, 1] / length) for height, length in HILLS]
    return np.asarray(sum(waves))


def random_queries(roads: Roads, blocks: list[int], *, seed: int = 0) -> list[Query]:
    """Return a query for each number of blocks: from a random crossing to one that is about so far away."""
    rng, found = np.random.default_rng(seed), list[Query]()
    while len(found) < len(blocks):
        source = int(rng.integers(len(roads.points)))
        away = np.hypot(*(roads.points - roads.points[source]).T) / BLOCK_M
        targets = np.flatnonzero(np.abs(away - blocks[len(found)]) < 1)
        if len(targets):
            found.append(Query(source + 1, int(rng.choice(targets)) + 1))
    return found


def write_files(roads: Roads, queries: list[Query], folder: Path) -> None:
    """Write the roads with their costs, and the queries."""
    columns = costs_of(roads)
    for name, column in columns.items():
        (folder / f"{name}.gr").write_text(arcs_text(roads._replace(seconds=column), name))
    arcs = np.stack([roads.sources + 1, roads.targets + 1, columns["seconds"], columns["metres"]], axis=1).tolist()
    lines = [(len(roads.points), len(arcs)), *arcs]
    (folder / "two_costs.txt").write_text("".join(f"{' '.join(map(str, line))}\n" for line in lines))
    (folder / "queries.txt").write_text("".join(f"{source} {target}\n" for source, target in queries))


if __name__ == "__main__":
    main()
