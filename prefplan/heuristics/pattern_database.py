"""Lower bounds of the cost-to-go: the max-min heuristic (equation 4), and pattern databases, which generalise it.

The max-min heuristic is h(p) = max_j d_j(s, q_j), with d_j the least cost of satisfying task j alone. With sets K of
tasks, h(p) = max_K d_K(s, q_K) is at least as large if every task is in one. Both are consistent: every edge of the
product maps onto an edge of T x A_K with the same cost, d_K is an exact distance there, and a maximum of consistent
bounds is consistent.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.abstraction import Projected
from prefplan.heuristics.cost_to_go import Backward, enter_costs
from prefplan.heuristics.landmarks import Landmarks, landmark_bound
from prefplan.heuristics.projections import Projections, place_of
from prefplan.heuristics.task_sets import TaskSets, joined_groups, table_entry, task_sets
from prefplan.product.kernels import INFINITE, UNREACHABLE, Integer, bare_kernel

ENTRIES, STAGED_ENTRIES = 1_000_000, 30_000_000
"""Most entries of all tables together, unless single tasks need more: they take half a second. With stages an entry
takes a tenth of the time."""

GROUPED_ENTRIES = 1_000_000
"""Most entries of a first table, over two groups of tasks: it takes 4 ms. For 12 tasks of five states groups have three
tasks; with a limit a fifth as large, a plan of 12 tasks takes three times as long."""

DEEPEST = 5
"""Most tasks in a set when tables are over all sets of one size and a search for one plan is long."""


# Columns of a product state's row; see `raise_bound`.
COST_BOUND, LOOKED, LIKELY = range(3)


class Patterns(NamedTuple):
    """Tables for P sets of k tasks.

    Attributes:
        sets: the sets. base: (P,) int64, where the table of each begins.
        table: (entries,) int32, costs cut off at UNREACHABLE - 1, which keeps the bound consistent.
        add_up: whether the bound is the sum of the entries, not the largest.
    """

    sets: TaskSets
    base: np.ndarray
    table: np.ndarray
    add_up: bool


def levels_of_sets(
    backward: Backward, wanted: int | None, *, single: bool, max_entries: float
) -> list[list[tuple[int, ...]]]:
    """Return the sets of tasks to begin with, and those that replace them when a search is long.

    Measured on 10 x 10 grids with up to 12 tasks: larger sets take longer to fill, but halve the expansions or more.

    Args:
        backward: the product.
        wanted: tasks in a set, if there are as many; None to choose.
        single: whether one plan is wanted, not the front.
        max_entries: most entries of all tables that fit into memory.
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
    """Return the tables of some sets of tasks; without any the bound is 0, even in dead ends."""
    return _filled(backward, members, backward.tabulate, add_up=False)


def projected_patterns(backward: Projected, groups: Sequence[tuple[int, ...]]) -> Patterns:
    """Return tables whose entries may be added: every action's cost is counted in at most one of them."""

    def fill(tasks: tuple[int, ...], table: np.ndarray) -> None:
        enter_costs(backward.shared_cost_to_go(tasks, groups), table)

    return _filled(backward, groups, fill, add_up=True)


def _filled(
    backward: Backward | Projected,
    members: Sequence[tuple[int, ...]],
    fill: Callable[[tuple[int, ...], np.ndarray], None],
    *,
    add_up: bool,
) -> Patterns:
    """Return the tables of some sets of tasks, given how to fill each."""
    sets, entries = task_sets(backward, members)
    ends = np.cumsum(entries)
    table = np.empty(int(entries.sum()), dtype=np.int32)
    for tasks, first, end in zip(members, ends - entries, ends, strict=True):
        fill(tasks, table[first:end])
    return Patterns(sets, ends - entries, table, add_up)


def scaled(databases: Patterns, weight: float) -> Patterns:
    """Return tables of the costs times a weight, to be added: they guide a search, and are not admissible."""
    entries = np.minimum((databases.table * weight).astype(np.int64), UNREACHABLE - 1)
    table = np.where(databases.table < UNREACHABLE, entries, UNREACHABLE).astype(np.int32)
    return databases._replace(table=table, add_up=True)


@bare_kernel
def added_bound(databases: Patterns, projections: Projections | None, node: Integer, automata: np.ndarray) -> Integer:
    """Return the sum of the entries of all tables, at most INFINITE."""
    bound = np.int64(0)
    for p in range(databases.base.shape[0]):
        place = place_of(projections, databases.sets.projection, p, node)
        bound = min(bound + _entry(databases, place, automata, p), np.int64(INFINITE))
    return bound


@bare_kernel
def raise_bound(
    databases: Patterns, marks: Landmarks | None, node: Integer, automata: np.ndarray, known: np.ndarray, limit: Integer
) -> Integer:
    """Raise h(p) by one table after the other until it exceeds a limit or none is left, and return it.

    The state's row `known` keeps the `COST_BOUND` so far, how many bounds were `LOOKED` up (the tables in order, then
    the landmarks), and the `LIKELY` table, to look up first: the one that gave the parent's bound. Tables that add up
    must have been looked up.
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
