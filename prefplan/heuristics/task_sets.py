"""Sets of a few tasks, and the index of a product state's entry in the table of each.

The table of a set K has an entry for every node and every combination of the states of K's automata.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from prefplan.heuristics.abstraction import Projected
from prefplan.heuristics.cost_to_go import Backward
from prefplan.models.kernels import Integer, bare_kernel


class TaskSets(NamedTuple):
    """P sets of at most k tasks.

    Attributes:
        tasks: (P, k) int64. strides: (P, k) int64: entry = node + sum_j strides[j] q_j. Both are 0
            beyond a set's tasks.
        projection: (P,) int64, the projection of the model that each table is over; None where states are listed.
    """

    tasks: np.ndarray
    strides: np.ndarray
    projection: Any


def task_sets(backward: Backward | Projected, sets: Sequence[tuple[int, ...]]) -> tuple[TaskSets, np.ndarray]:
    """Return sets of tasks for the kernels, and (P,) the number of entries of each one's table."""
    tasks, strides = np.zeros((2, len(sets), max(map(len, sets), default=1)), dtype=np.int64)
    entries = np.array([backward.nodes_of(members) for members in sets], dtype=np.int64)
    sizes = backward.sizes.tolist()
    for p, members in enumerate(sets):
        for j, i in enumerate(members):
            tasks[p, j], strides[p, j] = i, entries[p]
            entries[p] *= sizes[i]
    projection = None
    if isinstance(backward, Projected):
        projection = np.array([backward.projection_of(members) for members in sets], dtype=np.int64)
    return TaskSets(tasks, strides, projection), entries


def joined_groups(tasks: int, groups: int) -> list[tuple[int, ...]]:
    """Return sets such that any two tasks share one: tasks are dealt into groups, and every two groups make a set."""
    dealt = [range(g, tasks, groups) for g in range(min(groups, tasks))]
    if len(dealt) == 1:
        return [tuple(dealt[0])]
    return [tuple(sorted((*one, *other))) for one, other in combinations(dealt, 2)]


@bare_kernel
def table_entry(sets: TaskSets, p: Integer, node: Integer, automata: np.ndarray) -> Integer:
    """Return the index in the table of set p; `node` is that of the set's projection."""
    entry = node
    for j in range(sets.tasks.shape[1]):
        entry += sets.strides[p, j] * automata[sets.tasks[p, j]]
    return entry
