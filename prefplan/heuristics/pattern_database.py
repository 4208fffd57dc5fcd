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
