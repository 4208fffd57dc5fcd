"""Lower bound of how much the preference value still grows (the second objective; the paper uses 0).

Tasks are split into disjoint blocks. For a block K, with b tasks satisfied outside it and S the set of satisfied tasks,
mu grows by at least rate_K(S & K, b) per unit of cost because of the tasks of K; b never falls, and rate_K never falls
in b. So the least sum of rate_K times cost over all trajectories that satisfy K, with b as it is now, is a lower bound.
It is an exact distance in T x A_K, or a consistent bound of one (`sweep`); the rates of disjoint blocks add up to at
most that of mu, so the bounds may be added.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import chain
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.abstraction import Projected
from prefplan.heuristics.cost_to_go import Backward
from prefplan.heuristics.pattern_database import Patterns
from prefplan.heuristics.projections import Projections, place_of
from prefplan.heuristics.task_sets import TaskSets, table_entry, task_sets
from prefplan.models.kernels import INFINITE, UNREACHABLE, Integer, bare_kernel
from prefplan.preferences.objective import Measure
from prefplan.preferences.terms import OrderRate

BLOCK_SIZE = 3
"""Most tasks in a block of several groups; with four, tables cost more than they save (10 x 10 grids, 7 and 8 tasks).
"""

BLOCK_ENTRIES = 5_000
"""Most entries of a block of several groups, for one number of tasks satisfied outside. With 200,000, fronts of
manipulation models with six or eight objects take twice as long; with 1, those of
weighted sums on grids up to 1.6 times."""

ALONE_ENTRIES = 4_000_000
"""Most entries of a block of one group, for one number of tasks satisfied outside."""


class Blocks(NamedTuple):
    """Tables for disjoint blocks of at most k tasks.

    Attributes:
        sets: the blocks. members: (B,) int64, as bits, the tasks that do not count as satisfied outside each.
        base: (B, N + 1) int64, where the table of each begins for a number of tasks satisfied outside.
        table: (entries,) int64, units of mu.
    """

    sets: TaskSets
    base: np.ndarray
    members: np.ndarray
    table: np.ndarray


def no_blocks(backward: Backward | Projected) -> Blocks:
    """Return no tables: the bound 0."""
    base, none = np.zeros((0, len(backward.sizes) + 1), dtype=np.int64), np.zeros(0, dtype=np.int64)
    return Blocks(task_sets(backward, [])[0], base, none, none)


def blocks(backward: Backward | Projected, measure: Measure, factor: Fraction, known: Patterns) -> Blocks:
    """Return the tables of a measure whose key is one additive entry; no tables if its growth has no bound but 0.

    Args:
        backward: the product.
        measure: how mu grows.
        factor: what a unit of cost is in units of mu.
        known: costs-to-go, of which those of single tasks are reused.
    """
    n = measure.tasks
    orders = [rate.groups for rate in measure.rate_terms if isinstance(rate, OrderRate)]
    named = set(range(n)).intersection(*({i for group in order for i in group} for order in orders))
    groups = (*(orders or [()])[0], *((i,) for i in range(n) if not orders or i not in chain(*orders[0])))
    split = _split(backward, groups)
    jobs: dict[tuple[tuple[int, ...], tuple[int, ...]], list[int]] = {}
    for members in split:
        subsets = range(2 ** len(members))
        done = np.array([sum(1 << i for j, i in enumerate(members) if s >> j & 1) for s in subsets], dtype=np.int64)
        for outside in range(n - len(members) + 1):
            rates = tuple(measure.rates(done, frozenset(members), outside, factor).tolist())
            jobs.setdefault((members, rates), []).append(outside)
    if not any(any(rates) for _, rates in jobs):
        return no_blocks(backward)

    def tabulate(job: tuple[tuple[int, ...], tuple[int, ...]]) -> np.ndarray:
        members, rates = job
        tasks = np.array(members, dtype=np.int64)
        size = backward.nodes_of(members) * int(np.prod(backward.sizes[tasks]))
        if not any(rates):
            return np.zeros(size, dtype=np.int64)
        if len(members) == 1 and known.sets.tasks.shape[1] == 1 and len(known.base) and not known.add_up:
            # For a single task, mu grows at one rate until the task is satisfied.
            cost = known.table[known.base[members[0]] :][:size].astype(np.int64)
            growth = np.minimum(cost >> backward.shift, (INFINITE - 1) // max(rates[0], 1)) * rates[0]
            return np.where(cost < UNREACHABLE, growth, INFINITE)
        return backward.cost_to_go(tasks, np.array(rates, dtype=np.int64), shift=backward.shift)

    tables = [tabulate(job) for job in jobs]
    sets, _ = task_sets(backward, split)
    base = np.zeros((len(split), n + 1), dtype=np.int64)
    first = 0
    for ((members, _), outsides), table in zip(jobs.items(), tables, strict=True):
        base[split.index(members), outsides] = first
        first += len(table)
    # Only tasks that every order names count as satisfied outside a block: a smaller number is still admissible.
    bits = np.array([sum(1 << i for i in range(n) if i in members or i not in named) for members in split], np.int64)
    return Blocks(sets, base, bits, np.concatenate(tables))


def _split(backward: Backward | Projected, groups: tuple[tuple[int, ...], ...]) -> list[tuple[int, ...]]:
    """Return blocks of groups that are neighbours in the desired order; groups with too large tables are in none."""
    found: list[tuple[int, ...]] = []
    for group in groups:
        joined = (found[-1] if found else ()) + group
        entries = backward.entries_of(joined)
        if found and len(joined) <= BLOCK_SIZE and entries <= BLOCK_ENTRIES:
            found[-1] = joined
        elif backward.entries_of(group) <= ALONE_ENTRIES:
            found.append(group)
    return found


@bare_kernel
def block_entry(tables: Blocks, b: Integer, node: Integer, automata: np.ndarray, satisfied: Integer) -> Integer:
    """Return the index of block b's bound in the table; `node` is that of the block's projection."""
    rest = satisfied & ~tables.members[b]
    outside = 0
    while rest:
        rest &= rest - 1
        outside += 1
    return tables.base[b, outside] + table_entry(tables.sets, b, node, automata)


@bare_kernel
def preference_bound(
    tables: Blocks,
    projections: Projections | None,
    node: Integer,
    automata: np.ndarray,
    satisfied: Integer,
) -> Integer:
    """Return a lower bound, at most INFINITE, of the growth of mu from a product state to the end."""
    bound = np.int64(0)
    for b in range(tables.members.shape[0]):
        place = place_of(projections, tables.sets.projection, b, node)
        entry = block_entry(tables, b, place, automata, satisfied)
        bound = min(bound + tables.table[entry], np.int64(INFINITE))
    return bound
