"""Lower bounds of the cost-to-go: max-min (equation 4) and its generalisation to pattern databases.

The max-min heuristic is h(p) = max_j d_j(s, q_j), with d_j the exact cost of satisfying task j alone. The same with
sets K of tasks, h(p) = max_K d_K(s, q_K), is at least as large. Both are consistent: every edge of the product maps
onto an edge of T x A_K with the same cost, d_K is an exact distance there, and a maximum of consistent bounds is
consistent.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations
from math import comb
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.abstraction import Projected
from prefplan.heuristics.cost_to_go import Backward
from prefplan.heuristics.landmarks import Landmarks, landmark_bound
from prefplan.heuristics.projections import Projections, projected
from prefplan.heuristics.task_sets import TaskSets, no_task_sets, table_entry, task_sets
from prefplan.product.kernels import INFINITE, Integer, bare_kernel

ENTRIES, STAGED_ENTRIES = 1_000_000, 30_000_000
"""Entries of all tables together that building may cost, unless one task at a time needs more: half a second. Those
filled stage by stage cost a tenth each."""

UNREACHABLE = 2**31 - 1
"""Stands for INFINITE in tables, whose entries have 32 bits: with 64 a front of eight tasks takes a tenth longer."""


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
    """Return no tables: the search without a heuristic still knows which tasks are dead ends only by trying."""
    return Patterns(no_task_sets(), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int32))


def count_entries(backward: Backward, k: int) -> float:
    """Return about how many entries the tables of all sets of k tasks have."""
    return backward.nodes * comb(len(backward.sizes), k) * float(np.mean(backward.sizes)) ** k


def pattern_size(backward: Backward, wanted: int | None, *, single: bool, max_entries: float) -> int:
    """Return how many tasks a set has: as many as are wanted, or else as many as make the tables pay.

    Measured on 10 x 10 grids with up to 12 tasks: a set more costs its tables, and halves or quarters what is expanded.

    Args:
        backward: the product.
        wanted: tasks in a set, if there are as many; None to choose.
        single: whether one plan is wanted, not the front.
        max_entries: entries of all tables that fit the memory.
    """
    tasks = len(backward.sizes)
    if wanted is not None:
        return min(wanted, tasks)
    if backward.stages:
        largest, most = (3 if single else 4), STAGED_ENTRIES
    else:
        largest, most = (2 if tasks < 7 else 3) if single else (3 if tasks < 10 else 4), ENTRIES
    for k in range(min(largest, tasks), 1, -1):
        if count_entries(backward, k) <= min(most, max_entries):
            return k
    return 1


def patterns(backward: Backward, k: int) -> Patterns:
    """Return the tables of all sets of k tasks; none for 0."""
    if k == 0:
        return no_patterns()
    sets = list(combinations(range(len(backward.sizes)), k))
    alike = np.ones(2**k, dtype=np.int64)
    return _filled(backward, sets, (backward.cost_to_go(np.array(members), alike) for members in sets))


def projected_patterns(backward: Projected) -> Patterns:
    """Return tables whose entries may be added up: every action's cost is counted in one of them at the most."""
    groups = backward.groups()
    return _filled(backward, groups, (backward.shared_cost_to_go(members, groups) for members in groups))


def _filled(
    backward: Backward | Projected, members: Sequence[tuple[int, ...]], costs_to_go: Iterable[np.ndarray]
) -> Patterns:
    """Return the tables of some sets of tasks, given the costs-to-go of each."""
    sets, entries = task_sets(backward, members)
    ends = np.cumsum(entries)
    base = ends - entries
    table = np.empty(ends[-1], dtype=np.int32)
    for first, end, costs in zip(base, ends, costs_to_go, strict=True):
        table[first:end] = np.where(costs < INFINITE, np.minimum(costs, UNREACHABLE - 1), UNREACHABLE)
    return Patterns(sets, base, table)


def scaled(databases: Patterns, weight: float) -> Patterns:
    """Return tables of so many times the costs: no bounds, but they guide a search."""
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

    What is known of p is kept in `known`: `COST_BOUND` so far, that so many bounds were `LOOKED` up, first that of
    landmarks, then one table after the other, and the `LIKELY` table, to look up before all: the one that gave the
    bound of the state before.
    """
    bound, likely, looked = known[COST_BOUND], known[LIKELY], known[LOOKED]
    if looked == 0:
        if likely < databases.base.shape[0]:
            bound = max(bound, _entry(databases, node, automata, likely))
        if bound <= limit:
            bound = max(bound, landmark_bound(marks, node, automata))
            looked = np.int64(1)
    while 0 < looked <= databases.base.shape[0] and bound <= limit:
        entry = _entry(databases, node, automata, looked - 1)
        if entry > bound:
            bound, likely = entry, looked - 1
        looked += 1
    known[COST_BOUND], known[LOOKED], known[LIKELY] = bound, looked, likely
    return bound


@bare_kernel
def _entry(databases: Patterns, node: Integer, automata: np.ndarray, p: Integer) -> np.int64:
    cost = np.int64(databases.table[databases.base[p] + table_entry(databases.sets, p, node, automata)])
    return np.int64(INFINITE) if cost == UNREACHABLE else cost
