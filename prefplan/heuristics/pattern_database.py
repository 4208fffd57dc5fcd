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
from prefplan.product.successors import Integer, bare_kernel

ENTRIES, STAGED_ENTRIES = 6_000_000, 30_000_000
"""Entries of all tables together that building may cost, unless one task at a time needs more; those filled stage by
stage cost a tenth each."""


class Patterns(NamedTuple):
    """Tables for P sets of k tasks.

    Attributes:
        tasks: (P, k) int64. strides: (P, k) int64. base: (P,) int64: entry = base + node + sum_j strides[j] q_j.
        table: (entries,) int64.
    """

    tasks: np.ndarray
    strides: np.ndarray
    base: np.ndarray
    table: np.ndarray


def no_patterns() -> Patterns:
    """Return no tables: the search without a heuristic still knows which tasks are dead ends only by trying."""
    empty = np.zeros((0, 1), dtype=np.int64)
    return Patterns(empty, empty, empty[:, 0], empty[:, 0])


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


def patterns(backward: Backward, k: int) -> Patterns:
    """Return the tables of all sets of k tasks."""
    sets = np.array(list(combinations(range(len(backward.sizes)), k)), dtype=np.int64)
    strides = np.cumprod(np.insert(backward.sizes[sets], 0, backward.nodes, axis=1), axis=1)
    ends = np.cumsum(strides[:, -1])
    base = ends - strides[:, -1]
    table = np.empty(ends[-1], dtype=np.int64)
    for p, tasks in enumerate(sets):
        table[base[p] : ends[p]] = cost_to_go(backward, tasks, np.ones(2**k, dtype=np.int64))
    return Patterns(sets, strides[:, :-1].copy(), base, table)


@bare_kernel
def cost_bound(databases: Patterns, node: Integer, automata: np.ndarray) -> Integer:
    """Return h(p): the largest of all sets' entries."""
    bound = np.int64(0)
    for p in range(databases.base.shape[0]):
        entry = databases.base[p] + node
        for j in range(databases.tasks.shape[1]):
            entry += databases.strides[p, j] * automata[databases.tasks[p, j]]
        bound = max(bound, databases.table[entry])
    return bound
