"""Lower bounds of the cost-to-go: max-min (equation 4) and its generalisation to pattern databases.

The max-min heuristic is h(p) = max_j d_j(s, q_j), with d_j the exact cost of satisfying task j alone. The same with
sets K of tasks, h(p) = max_K d_K(s, q_K), is at least as large. Both are consistent: every edge of the product maps
onto an edge of T x A_K with the same cost, d_K is an exact distance there, and a maximum of consistent bounds is
consistent.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.abstraction import Projected
from prefplan.heuristics.cost_to_go import Backward, enter_costs
from prefplan.heuristics.landmarks import Landmarks, landmark_bound
from prefplan.heuristics.projections import Projections, projected
from prefplan.heuristics.task_sets import TaskSets, joined_groups, no_task_sets, table_entry, task_sets
from prefplan.product.kernels import INFINITE, UNREACHABLE, Integer, bare_kernel

ENTRIES, STAGED_ENTRIES = 1_000_000, 30_000_000
"""Entries of all tables together that building may cost, unless one task at a time needs more: half a second. Those
filled stage by stage cost a tenth each."""

GROUPED_ENTRIES = 1_000_000
"""Entries of a table of two groups of tasks to begin with: it takes 4 ms. For 12 tasks of five states these are groups
of three; with tables of a fifth as many entries, a plan of 12 tasks takes three times as long."""

DEEPEST = 5
"""Tasks in a set that a long search for one plan may call for, if all such sets have tables."""


# Columns of a product state's row that hold what is known of its bound.
COST_BOUND, LOOKED, LIKELY = range(3)


class Patterns(NamedTuple):
    """Tables for P sets of k tasks.

    Attributes:
        sets: the sets. base: (P,) int64, where each one's table begins.
        table: (entries,) int32: UNREACHABLE - 1 stands for all larger costs, and is a consistent bound.
    """

    sets: TaskSets
    base: np.ndarray
    table: np.ndarray


def no_patterns() -> Patterns:
    """Return no tables: without a heuristic the search finds dead ends only by trying."""
    return Patterns(no_task_sets(), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int32))


def levels_of_sets(
    backward: Backward, wanted: int | None, *, single: bool, max_entries: float
) -> list[list[tuple[int, ...]]]:
    """Return the sets of tasks to begin with, and those that take their place when a search is long.

    Measured on 10 x 10 grids with up to 12 tasks: larger sets cost their tables, and spare half or more of what is
    expanded.

    Args:
        backward: the product.
        wanted: tasks in a set, if there are as many; None to choose.
        single: whether one plan is wanted, not the front.
        max_entries: entries of all tables that fit the memory.
    """
    tasks = len(backward.sizes)
    if wanted is not None:
        return [_all_sets(tasks, min(wanted, tasks))]
    if single and backward.monotone:
        levels = [joined_groups(tasks, groups) for groups in range(2, tasks + 1)]
        for g, sets in enumerate(levels):
            largest_table = max(map(backward.entries_of, sets))
            if largest_table <= GROUPED_ENTRIES and count_entries(backward, sets) <= min(STAGED_ENTRIES, max_entries):
                return levels[g::-1]
    if backward.stages:
        largest, most = (3 if single else 4), STAGED_ENTRIES
    else:
        largest, most = (2 if tasks < 7 else 3) if single else (3 if tasks < 10 else 4), ENTRIES
    size = min(largest, tasks)
    while size > 1 and count_entries(backward, _all_sets(tasks, size)) > min(most, max_entries):
        size -= 1
    return [_all_sets(tasks, k) for k in range(size, min(DEEPEST, tasks) + 1)]


def count_entries(backward: Backward, sets: Sequence[tuple[int, ...]]) -> int:
    """Return how many entries the tables of some sets of tasks have."""
    return sum(map(backward.entries_of, sets))


def _all_sets(tasks: int, k: int) -> list[tuple[int, ...]]:
    """Return all sets of k tasks; none for 0."""
    return list(combinations(range(tasks), k)) if k else []


def patterns(backward: Backward, members: Sequence[tuple[int, ...]]) -> Patterns:
    """Return the tables of some sets of tasks."""
    return _filled(backward, members, backward.tabulate)


def projected_patterns(backward: Projected) -> Patterns:
    """Return tables whose entries may be added up: every action's cost is counted in one of them at the most."""
    groups = backward.groups()
    return _filled(backward, groups, lambda tasks, table: enter_costs(backward.shared_cost_to_go(tasks, groups), table))


def _filled(
    backward: Backward | Projected,
    members: Sequence[tuple[int, ...]],
    fill: Callable[[tuple[int, ...], np.ndarray], None],
) -> Patterns:
    """Return the tables of some sets of tasks, given how to fill each."""
    if not members:
        return no_patterns()
    sets, entries = task_sets(backward, members)
    ends = np.cumsum(entries)
    known = Patterns(sets, ends - entries, np.empty(ends[-1], dtype=np.int32))
    for tasks, first, end in zip(members, known.base, ends, strict=True):
        fill(tasks, known.table[first:end])
    return known


def scaled(databases: Patterns, weight: float) -> Patterns:
    """Return tables of the costs times a weight: no bounds, but they guide a search."""
    entries = np.minimum((databases.table * weight).astype(np.int64), UNREACHABLE - 1)
    return databases._replace(table=np.where(databases.table < UNREACHABLE, entries, UNREACHABLE).astype(np.int32))


@bare_kernel
def added_bound(
    databases: Patterns, projections: Projections, digits: np.ndarray, node: Integer, automata: np.ndarray
) -> Integer:
    """Return the sum of the entries of all tables, INFINITE at most."""
    bound = np.int64(0)
    for p in range(databases.base.shape[0]):
        place = projected(projections, databases.sets.projection[p], digits, node)
        bound = min(bound + _entry(databases, place, automata, p), np.int64(INFINITE))
    return bound


@bare_kernel
def raise_bound(
    databases: Patterns, marks: Landmarks, node: Integer, automata: np.ndarray, known: np.ndarray, limit: Integer
) -> Integer:
    """Look bounds up for h(p) until it exceeds a limit or is complete, and return what it is so far.

    What is known of p is kept in `known`: the `COST_BOUND` so far, how many bounds were `LOOKED` up, one table
    after the other and then that of landmarks, and the `LIKELY` table, to look up first: the one that gave the bound
    of the state before.
    """
    bound, likely, looked, tables = known[COST_BOUND], known[LIKELY], known[LOOKED], databases.base.shape[0]
    if looked == 0 and likely < tables:
        bound = max(bound, _entry(databases, node, automata, likely))
    while looked < tables and bound <= limit:
        entry = _entry(databases, node, automata, looked)
        if entry > bound:
            bound, likely = entry, looked
        looked += 1
    if looked == tables and bound <= limit:
        bound = max(bound, landmark_bound(marks, node, automata))
        looked += 1
    known[COST_BOUND], known[LOOKED], known[LIKELY] = bound, looked, likely
    return bound


@bare_kernel
def _entry(databases: Patterns, node: Integer, automata: np.ndarray, p: Integer) -> np.int64:
    cost = np.int64(databases.table[databases.base[p] + table_entry(databases.sets, p, node, automata)])
    return np.int64(INFINITE) if cost == UNREACHABLE else cost
