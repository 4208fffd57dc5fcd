"""Lower bounds of the cost-to-go: the max-min heuristic (equation 4), and pattern databases, which generalise it.

The max-min heuristic is h(p) = max_j d_j(s, q_j), with d_j the least cost of satisfying task j alone. With sets K of
tasks, h(p) = max_K d_K(s, q_K) is at least as large if every task is in one. Both are consistent: every edge of the
product maps onto an edge of T x A_K with the same cost, d_K is an exact distance there, and a maximum of consistent
bounds is consistent.

The table of a set K has an entry for every node and every combination of the states of K's automata. Those of several
costs are over the same sets of tasks, so that one index serves all costs.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from prefplan.heuristics.cost_to_go import Backward
from prefplan.heuristics.landmarks import Landmarks, landmark_bound
from prefplan.heuristics.projected_backward import ProjectedBackward
from prefplan.heuristics.projection import ProjectionArrays, place_of
from prefplan.models.kernels import INFINITE, UNREACHABLE, Integer, bare_kernel

SWEPT_ENTRIES, SEARCHED_ENTRIES = 1_000_000, 30_000
"""Most entries of a table of several tasks, if it is swept or filled by Dijkstra: either takes about 10 ms. With a
fourth of the first, a plan of 12 tasks takes four times as long; with twice the second, plans of 9 and 12 tasks that
avoid places 1.5 and 1.1 times; with a third, a front of six tasks on a 30 x 30 grid 1.05 times."""

DEEP_ENTRIES = 20_000_000
"""Most entries of a swept table for a long search for one plan, about 0.15 s. Without such tables plans of 10 and 12
tasks take as long in the median, but one in seven 13 and 2 times as long."""

ENTRIES = 60_000_000
"""Most entries of all tables of several tasks: sweeping them takes 0.4 s."""


# Columns of a product state's row; see `raise_bound`.
COST_BOUND, LOOKED, LIKELY = range(3)


class TaskSets(NamedTuple):
    """P sets of at most k tasks, each with a table.

    Attributes:
        tasks: (P, k) int64. strides: (P, k) int64: entry = node + sum_j strides[j] q_j. Both are 0 beyond a set's
            tasks.
        projection: (P,) int64, the projection of the model that each table is over; None where states are listed.
    """

    tasks: np.ndarray
    strides: np.ndarray
    projection: Any


class Patterns(NamedTuple):
    """Tables for P sets of tasks and D costs.

    Attributes:
        sets: the sets. base: (P,) int64, where the table of each begins.
        table: (D, entries) int32, costs cut off at UNREACHABLE - 1, which keeps the bound consistent.
        add_up: whether the bound is the sum of the entries, not the largest.
    """

    sets: TaskSets
    base: np.ndarray
    table: np.ndarray
    add_up: bool


def task_sets(backward: Backward | ProjectedBackward, sets: Sequence[tuple[int, ...]]) -> tuple[TaskSets, np.ndarray]:
    """Return sets of tasks for the kernels, and (P,) the number of entries of each one's table."""
    tasks, strides = np.zeros((2, len(sets), max(map(len, sets), default=1)), dtype=np.int64)
    entries = np.array([backward.nodes_of(members) for members in sets], dtype=np.int64)
    for p, members in enumerate(sets):
        for j, i in enumerate(members):
            tasks[p, j], strides[p, j] = i, entries[p]
            entries[p] *= backward.sizes[i]
    projection = None
    if isinstance(backward, ProjectedBackward):
        projection = np.array([backward.projection_of(members) for members in sets], dtype=np.int64)
    return TaskSets(tasks, strides, projection), entries


def sets_of_tasks(
    backward: Backward, wanted: int | None, max_entries: float, *, deep: bool = False
) -> list[tuple[int, ...]]:
    """Return the sets of tasks to fill tables for: any two tasks share one, unless these would be too large.

    Args:
        backward: the product.
        wanted: tasks in a set, if there are as many, and then all such sets; None to choose.
        max_entries: most entries of all tables that fit into memory.
        deep: whether the tables are for a search for one plan that is long.
    """
    tasks = len(backward.sizes)
    if wanted is not None:
        return list(combinations(range(tasks), min(wanted, tasks))) if wanted else []
    swept = DEEP_ENTRIES if deep else SWEPT_ENTRIES
    largest = swept if backward.is_swept else SEARCHED_ENTRIES
    for groups in range(2, tasks + 1):
        sets = joined_groups(tasks, groups)
        entries = [backward.entries_of(members) for members in sets]
        if max(entries) <= largest and sum(entries) <= min(ENTRIES, max_entries):
            return sets
    return [(i,) for i in range(tasks)]


def joined_groups(tasks: int, groups: int) -> list[tuple[int, ...]]:
    """Return sets such that any two tasks share one: tasks are dealt into groups, and every two groups make a set."""
    dealt = [range(g, tasks, groups) for g in range(min(groups, tasks))]
    if len(dealt) == 1:
        return [tuple(dealt[0])]
    return [tuple(sorted((*one, *other))) for one, other in combinations(dealt, 2)]


def patterns(backwards: Sequence[Backward | ProjectedBackward], sets: Sequence[tuple[int, ...]]) -> Patterns:
    """Return the tables of some sets of tasks; without any the bound is 0, even in dead ends.

    Args:
        backwards: (D,) what fills tables of each cost. Where states are generated, entries are added: every action's
            cost is counted in at most one of the tables.
        sets: the sets.
    """
    laid, entries = task_sets(backwards[0], sets)
    ends = np.cumsum(entries)
    table = np.empty((len(backwards), int(entries.sum())), dtype=np.int32)
    for d, backward in enumerate(backwards):
        for tasks, first, end in zip(sets, ends - entries, ends, strict=True):
            if isinstance(backward, ProjectedBackward):
                backward.fill_shared(table[d, first:end], tasks, sets)
            else:
                backward.fill(table[d, first:end], tasks)
    return Patterns(laid, ends - entries, table, isinstance(backwards[0], ProjectedBackward))


def scaled(databases: Patterns, weight: float) -> Patterns:
    """Return tables of the costs times a weight, to be added: they guide a search, and are not admissible."""
    entries = np.minimum((databases.table * weight).astype(np.int64), UNREACHABLE - 1)
    table = np.where(databases.table < UNREACHABLE, entries, UNREACHABLE).astype(np.int32)
    return databases._replace(table=table, add_up=True)


@bare_kernel
def cost_bound(
    databases: Patterns, projections: ProjectionArrays | None, node: Integer, automata: np.ndarray, d: Integer
) -> Integer:
    """Return the bound of one of the costs, at most INFINITE."""
    bound = np.int64(0)
    for p in range(databases.base.shape[0]):
        cost = _cost(databases, place_of(projections, databases.sets.projection, p, node), automata, p, d)
        bound = min(bound + cost, np.int64(INFINITE)) if databases.add_up else max(bound, cost)
    return bound


@bare_kernel
def raise_bound(
    databases: Patterns, marks: Landmarks | None, node: Integer, automata: np.ndarray, known: np.ndarray, limit: Integer
) -> Integer:
    """Raise h(p) of the first cost by one table after the other until it exceeds a limit or none is left; return it.

    The state's row `known` keeps the `COST_BOUND` so far, how many bounds were `LOOKED` up (the tables in order, then
    the landmarks), and the `LIKELY` table, to look up first: the one that gave the parent's bound. Tables that add up
    must have been looked up.
    """
    bound, likely, looked, tables = known[COST_BOUND], known[LIKELY], known[LOOKED], databases.base.shape[0]
    if looked == 0 and likely < tables:
        bound = max(bound, _cost(databases, node, automata, likely, 0))
    while looked < tables and bound <= limit:
        cost = _cost(databases, node, automata, looked, 0)
        if cost > bound:
            bound, likely = cost, looked
        looked += 1
    if looked == tables and bound <= limit:
        bound = max(bound, landmark_bound(marks, node, automata))
        looked += 1
    known[COST_BOUND], known[LOOKED], known[LIKELY] = bound, looked, likely
    return bound


@bare_kernel
def _cost(databases: Patterns, node: Integer, automata: np.ndarray, p: Integer, d: Integer) -> np.int64:
    cost = np.int64(databases.table[d, databases.base[p] + table_entry(databases.sets, p, node, automata)])
    return np.int64(INFINITE) if cost == UNREACHABLE else cost


@bare_kernel
def table_entry(sets: TaskSets, p: Integer, node: Integer, automata: np.ndarray) -> Integer:
    """Return the index in the table of set p; `node` is that of the set's projection."""
    entry = node
    for j in range(sets.tasks.shape[1]):
        entry += sets.strides[p, j] * automata[sets.tasks[p, j]]
    return entry
