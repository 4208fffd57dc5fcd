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
from prefplan.product.successors import INFINITE, Integer, bare_kernel

ENTRIES, STAGED_ENTRIES = 6_000_000, 30_000_000
"""Entries of all tables together that building may cost, unless one task at a time needs more; those filled stage by
stage cost a tenth each."""

UNREACHABLE = 2**31 - 1
"""Stands for INFINITE in tables, whose entries have 32 bits: with 64 a front of eight tasks takes a tenth longer."""


# Columns of a product state's row that hold what is known of its bound.
COST_BOUND, LOOKED, LIKELY = range(3)


class Patterns(NamedTuple):
    """Tables for P sets of k tasks.

    Attributes:
        tasks: (P, k) int64. strides: (P, k) int64. base: (P,) int64: entry = base + node + sum_j strides[j] q_j.
        table: (entries,) int32: UNREACHABLE - 1 stands for all larger costs, and is a consistent bound.
    """

    tasks: np.ndarray
    strides: np.ndarray
    base: np.ndarray
    table: np.ndarray


def no_patterns() -> Patterns:
    """Return no tables: the search without a heuristic still knows which tasks are dead ends only by trying."""
    empty = np.zeros((0, 1), dtype=np.int64)
    return Patterns(empty, empty, empty[:, 0], np.zeros(0, dtype=np.int32))


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
        table[base[p] : ends[p]] = np.where(costs < INFINITE, np.minimum(costs, UNREACHABLE - 1), UNREACHABLE)
    return Patterns(sets, strides[:, :-1].copy(), base, table)


@bare_kernel
def raise_bound(databases: Patterns, node: Integer, automata: np.ndarray, known: np.ndarray, limit: Integer) -> Integer:
    """Look tables up for h(p) until it exceeds a limit or is complete, and return what it is so far.

    What is known of p is kept in `known`: `COST_BOUND` so far, that so many tables were `LOOKED` up, and the `LIKELY`
    one, to look up first: the one that gave the bound of the state before.
    """
    bound, likely, p = known[COST_BOUND], known[LIKELY], known[LOOKED]
    if p == 0 and likely < databases.base.shape[0]:
        bound = _entry(databases, node, automata, likely)
    while p < databases.base.shape[0] and bound <= limit:
        entry = _entry(databases, node, automata, p)
        if entry > bound:
            bound, likely = entry, p
        p += 1
    known[COST_BOUND], known[LOOKED], known[LIKELY] = bound, p, likely
    return bound


@bare_kernel
def _entry(databases: Patterns, node: Integer, automata: np.ndarray, p: Integer) -> np.int64:
    entry = databases.base[p] + node
    for j in range(databases.tasks.shape[1]):
        entry += databases.strides[p, j] * automata[databases.tasks[p, j]]
    cost = np.int64(databases.table[entry])
    return np.int64(INFINITE) if cost == UNREACHABLE else cost
