"""Lower bounds of the cost-to-go: max-min (equation 4) and its generalisation to pattern databases.

The max-min heuristic is h(p) = max_j d_j(s, q_j), with d_j the exact cost of satisfying task j alone. The same with
sets K of tasks, h(p) = max_K d_K(s, q_K), is at least as large. Both are consistent: every edge of the product maps
onto an edge of T x A_K with the same cost, d_K is an exact distance there, and a maximum of consistent bounds is
consistent.
"""

from __future__ import annotations

from itertools import combinations
from math import comb
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.cost_to_go import Backward, cost_to_go
from prefplan.heuristics.landmarks import Landmarks, landmark_bound
from prefplan.heuristics.projections import Projected, Projections, projected
from prefplan.product.kernels import Integer, bare_kernel
from prefplan.product.successors import INFINITE

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
        tasks: (P, k) int64. strides: (P, k) int64. base: (P,) int64: entry = base + node + sum_j strides[j] q_j.
        projection: (P,) int64, in which projection of the model each table is.
        table: (entries,) int32: UNREACHABLE - 1 stands for all larger costs, and is a consistent bound.
    """

    tasks: np.ndarray
    strides: np.ndarray
    base: np.ndarray
    projection: np.ndarray
    table: np.ndarray


def no_patterns() -> Patterns:
    """Return no tables: the search without a heuristic still knows which tasks are dead ends only by trying."""
    empty = np.zeros((0, 1), dtype=np.int64)
    return Patterns(empty, empty, empty[:, 0], empty[:, 0], np.zeros(0, dtype=np.int32))


def count_entries(backward: Backward, k: int) -> float:
    """Return about how many entries the tables of all sets of k tasks have."""
    return backward.nodes * comb(len(backward.sizes), k) * float(np.mean(backward.sizes)) ** k


def pattern_size(backward: Backward, *, single: bool, max_entries: float) -> int:
    """Return how many tasks a set has, so that the tables pay.

    Measured on 10 x 10 grids with up to 12 tasks: a set more costs its tables, and halves or quarters what is expanded.

    Args:
        backward: the product.
        single: whether one plan is wanted, not the front.
        max_entries: entries of all tables that fit the memory.
    """
    tasks = len(backward.sizes)
    if backward.stages:
        wanted, most = (3 if single else 4), STAGED_ENTRIES
    else:
        wanted, most = (2 if tasks < 7 else 3) if single else (3 if tasks < 10 else 4), ENTRIES
    for k in range(min(wanted, tasks), 1, -1):
        if count_entries(backward, k) <= min(most, max_entries):
            return k
    return 1


def patterns(backward: Backward, k: int) -> Patterns:
    """Return the tables of all sets of k tasks."""
    sets = np.array(list(combinations(range(len(backward.sizes)), k)), dtype=np.int64)
    strides = np.cumprod(np.insert(backward.sizes[sets], 0, backward.nodes, axis=1), axis=1)
    ends = np.cumsum(strides[:, -1])
    base = ends - strides[:, -1]
    table = np.empty(ends[-1], dtype=np.int32)
    for p, tasks in enumerate(sets):
        costs = cost_to_go(backward, tasks, np.ones(2**k, dtype=np.int64))
        table[base[p] : ends[p]] = as_entries(costs)
    return Patterns(sets, strides[:, :-1].copy(), base, np.zeros_like(base), table)


def as_entries(costs: np.ndarray) -> np.ndarray:
    """Return costs-to-go as the entries of a table."""
    return np.where(costs < INFINITE, np.minimum(costs, UNREACHABLE - 1), UNREACHABLE).astype(np.int32)


def projected_patterns(backward: Projected) -> Patterns:
    """Return tables whose entries may be added up: every action's cost is counted in one of them at the most."""
    groups = backward.groups()
    width = max(map(len, groups), default=1)
    # Places beyond a group's tasks add nothing.
    tasks, strides = np.zeros((2, len(groups), width), dtype=np.int64)
    tables = []
    for p, members in enumerate(groups):
        tasks[p, : len(members)] = members
        sizes = backward.sizes[np.array(members[:-1], dtype=np.int64)]
        strides[p, : len(members)] = np.cumprod(np.concatenate([[backward.nodes_of(members)], sizes]))
        tables.append(as_entries(backward.shared_cost_to_go(members, groups)))
    ends = np.cumsum([len(table) for table in tables], dtype=np.int64)
    base = ends - np.array([len(table) for table in tables], dtype=np.int64)
    projection = np.array([backward.projection_of(members) for members in groups], dtype=np.int64)
    return Patterns(tasks, strides, base, projection, np.concatenate(tables))


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
        place = projected(projections, databases.projection[p], digits, node)
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
    entry = databases.base[p] + node
    for j in range(databases.tasks.shape[1]):
        entry += databases.strides[p, j] * automata[databases.tasks[p, j]]
    cost = np.int64(databases.table[entry])
    return np.int64(INFINITE) if cost == UNREACHABLE else cost
