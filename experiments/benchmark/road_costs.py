"""Path queries on the roads of the made-up city with several costs: driving time, length and climb."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from experiments.benchmark.road_network import BLOCK_M, Roads, arcs_text
from prefplan import Problem, Task
from prefplan.models.graph_file import GraphFileModel

COSTS = ("seconds", "metres", "climb")
"""The costs, in the order of objectives; climbs are in decimetres."""

HILLS_M = ((30.0, 700.0), (10.0, 190.0))
"""Amplitudes and length scales of hills and of bumps on them, m."""

BLOCKS = (40, 40, 80, 80, 120, 120)
"""Straight-line distance between the ends of each query, blocks."""


class Query(NamedTuple):
    """A path query: source and target nodes."""

    source: int
    target: int


def costs_of(roads: Roads) -> dict[str, np.ndarray]:
    """Return the (E,) int64 costs of the roads, by name."""
    ends = roads.points[roads.targets], roads.points[roads.sources]
    climb = 10 * (heights(ends[0]) - heights(ends[1])).clip(min=0)
    metres = np.hypot(*(ends[0] - ends[1]).T)
    columns = (roads.seconds, np.maximum(metres, 1), climb)
    return {name: np.rint(column).astype(np.int64) for name, column in zip(COSTS, columns, strict=True)}


def heights(points: np.ndarray) -> np.ndarray:
    """Return the (S,) heights of (S, 2) points, m."""
    waves = [height * np.sin(points[:, 0] / length) * np.cos(points[:, 1] / length) for height, length in HILLS_M]
    return np.asarray(sum(waves))


def random_queries(roads: Roads, blocks: Sequence[int] = BLOCKS) -> list[Query]:
    """Return a query for each number of blocks, from a random crossing to one at about that distance."""
    rng, found = np.random.default_rng(0), list[Query]()
    while len(found) < len(blocks):
        source = int(rng.integers(len(roads.points)))
        away = np.hypot(*(roads.points - roads.points[source]).T) / BLOCK_M
        targets = np.flatnonzero(np.abs(away - blocks[len(found)]) < 1)
        if len(targets):
            found.append(Query(source + 1, int(rng.choice(targets)) + 1))
    return found


def write_files(roads: Roads, folder: Path) -> None:
    """Write a DIMACS file of each cost, all with the same roads in the same order."""
    for name, column in costs_of(roads).items():
        (folder / f"{name}.gr").write_text(arcs_text(roads._replace(seconds=column), name))


def problem_between(folder: Path, costs: Sequence[str], query: Query) -> Problem:
    """Return a query as a problem without preferences: one task, to reach the target; each cost has a file."""
    files = {name: f"{name}.gr" for name in costs}
    model = GraphFileModel(folder, files, query.source, labels={str(query.target): ["goal"]})
    return Problem(model.transition_system(), [Task("arrive", "F goal")], [])
