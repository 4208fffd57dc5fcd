"""Lower bounds of the cost-to-go: max-min (equation 4) and its generalisation to pattern databases.

The max-min heuristic is h(p) = max_j d_j(s, q_j), with d_j the exact cost of satisfying task j alone. The same with
sets K of tasks, h(p) = max_K d_K(s, q_K), is at least as large. Both are consistent: every edge of the product maps
onto an edge of T x A_K with the same cost, d_K is an exact distance there, and a maximum of consistent bounds is
consistent.

A bound can be sharper where mu may only grow by so much: the tasks of K alone make mu grow at rate_K(S & K), which is
at most its rate, so ways to satisfy K that exceed the budget can be left out of d_K.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations
from math import comb
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.cost_to_go import Backward, cost_to_go
from prefplan.preferences.objective import Measure
from prefplan.product.successors import UNBOUNDED, Integer, bare_kernel

# Columns of a product state's row that hold what is known of its bound: the bound so far, how many tables were looked
# up for it, the table that it comes from, and the one that gave the largest bound under a budget.
COST_BOUND, LOOKED, LIKELY, TIGHT = range(4)
BOUND_COLUMNS = 4

ENTRIES, STAGED_ENTRIES = 6_000_000, 30_000_000
"""Entries of all tables together that building may cost, unless one task at a time needs more; those filled stage by
stage cost a tenth each."""


class Patterns(NamedTuple):
    """Tables for P sets of k tasks, and B budgets of mu's growth.

    Attributes:
        tasks: (P, k) int64. strides: (P, k) int64. base: (P,) int64: entry = base + node + sum_j strides[j] q_j.
        table: (B, entries) int64.
        budgets: (B,) int64, falling, units of mu; the first is no bound.
    """

    tasks: np.ndarray
    strides: np.ndarray
    base: np.ndarray
    table: np.ndarray
    budgets: np.ndarray


def no_patterns() -> Patterns:
    """Return no tables: the search without a heuristic still knows which tasks are dead ends only by trying."""
    empty = np.zeros((0, 1), dtype=np.int64)
    return Patterns(empty, empty, empty[:, 0], np.zeros((1, 0), dtype=np.int64), np.array([UNBOUNDED]))


def count_entries(backward: Backward, k: int) -> float:
    """Return about how many entries the tables of all sets of k tasks have."""
    return backward.nodes * comb(len(backward.sizes), k) * float(np.mean(backward.sizes)) ** k


def pattern_size(backward: Backward, *, single: bool, max_entries: float) -> int:
    """Return how many tasks a set has, so that the tables pay.

    Measured on 10 x 10 grids with up to 12 tasks: a set more costs its tables, and halves or quarters what is expanded.

    Args:
        backward: the product.
        single: whether one plan is wanted, not the front.
        max_entries: entries of all tables that memory has room for.
    """
    tasks = len(backward.sizes)
    if backward.stages:
        wanted, most = (3 if single and tasks < 10 else 4), STAGED_ENTRIES
    else:
        wanted, most = (2 if tasks < 7 else 3) if single else (3 if tasks < 10 else 4), ENTRIES
    for k in range(min(wanted, tasks), 1, -1):
        if count_entries(backward, k) <= min(most, max_entries):
            return k
    return 1


def patterns(
    backward: Backward,
    k: int,
    *,
    measure: Measure | None = None,
    factor: Fraction = Fraction(1),
    budgets: Sequence[int] = (),
) -> Patterns:
    """Return the tables of all sets of k tasks.

    Args:
        backward: the product.
        k: how many tasks a set has.
        measure: whose growth is bounded.
        factor: what a unit of cost is in units of mu.
        budgets: how much mu may grow, falling.
    """
    sets = [np.array(databases, dtype=np.int64) for databases in combinations(range(len(backward.sizes)), k)]
    levels = np.array([UNBOUNDED, *budgets], dtype=np.int64)
    cells = backward.sizes[np.stack(sets)]
    strides = np.cumprod(np.insert(cells, 0, backward.nodes, axis=1), axis=1)
    ends = np.cumsum(strides[:, -1])
    base = ends - strides[:, -1]
    table = np.empty((len(levels), ends[-1]), dtype=np.int64)
    for p, tasks in enumerate(sets):
        rates = None
        if measure and budgets:
            members = tasks.tolist()
            rates = np.array([_rate(measure, members, s, factor) for s in range(2**k)], dtype=np.int64)
        bounds = cost_to_go(backward, tasks, rates=rates, budgets=None if rates is None else levels)
        table[:, base[p] : ends[p]] = bounds
    return Patterns(np.stack(sets), strides[:, :-1].copy(), base, table, levels)


def _rate(measure: Measure, members: list[int], satisfied: int, factor: Fraction) -> int:
    """Return a lower bound of mu's rate from some tasks alone, in units of mu for a unit of cost."""
    bits = sum(1 << i for j, i in enumerate(members) if satisfied >> j & 1)
    return int(sum((rate.among(frozenset(members), bits) for rate in measure.rates), Fraction(0)) * factor)


@bare_kernel
def cost_bound(databases: Patterns, node: Integer, automata: np.ndarray) -> Integer:
    """Return h(p): the largest of all sets' entries."""
    bound = np.int64(0)
    for p in range(databases.base.shape[0]):
        bound = max(bound, _entry(databases, node, automata, 0, p))
    return bound


@bare_kernel
def look_further(
    databases: Patterns, node: Integer, automata: np.ndarray, known: np.ndarray, limit: Integer
) -> Integer:
    """Go on with h(p) from where it was left, until it exceeds a limit or is complete, and return what it is so far.

    What is known of p is kept in its known: `COST_BOUND` so far, that so many sets were `LOOKED` at, and the `LIKELY`
    one, to look at first.
    """
    bound, likely = np.int64(known[COST_BOUND]), np.int64(known[LIKELY])
    p = np.int64(known[LOOKED])
    if p == 0 and likely < databases.base.shape[0]:
        bound = _entry(databases, node, automata, 0, likely)
    while p < databases.base.shape[0] and bound <= limit:
        entry = _entry(databases, node, automata, 0, p)
        if entry > bound:
            bound, likely = entry, p
        p += 1
    known[COST_BOUND], known[LOOKED], known[LIKELY] = bound, p, likely
    return bound


@bare_kernel
def look_under_budget(
    databases: Patterns, node: Integer, automata: np.ndarray, known: np.ndarray, level: Integer, limit: Integer
) -> Integer:
    """Return h(p) for one of the budgets: the largest of all sets' entries, or the first that exceeds a limit.

    The set that was the last to give the bound, `TIGHT` in the known of p, is looked at first.
    """
    tight = np.int64(known[TIGHT])
    bound = np.int64(0)
    if tight < databases.base.shape[0]:
        bound = _entry(databases, node, automata, level, tight)
    p = 0
    while p < databases.base.shape[0] and bound <= limit:
        entry = _entry(databases, node, automata, level, p)
        if entry > bound:
            bound, tight = entry, np.int64(p)
        p += 1
    known[TIGHT] = tight
    return bound


@bare_kernel
def _entry(databases: Patterns, node: Integer, automata: np.ndarray, level: Integer, p: Integer) -> np.int64:
    entry = databases.base[p] + node
    for j in range(databases.tasks.shape[1]):
        entry += databases.strides[p, j] * automata[databases.tasks[p, j]]
    return np.int64(databases.table[level, entry])
