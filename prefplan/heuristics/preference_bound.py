"""Lower bound of how much the preference value still grows (the second objective; the paper uses 0).

Tasks are split into disjoint blocks. For a block K, with b tasks satisfied outside it and S the set of satisfied tasks,
mu grows by at least rate_K(S & K, b) per unit of cost because of the tasks of K; b never falls, and rate_K never falls
in b. So the least sum of rate_K times cost over all trajectories that satisfy K, with b as it is now, is a lower bound.
It is an exact distance in T x A_K, or a consistent bound of one (`sweep`); the rates of disjoint blocks add up to at
most that of mu, so the bounds may be added.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.cost_to_go import Backward
from prefplan.heuristics.pattern_database import Patterns, TaskSets, table_entry, task_sets
from prefplan.heuristics.projected_backward import ProjectedBackward
from prefplan.heuristics.projection import ProjectionArrays, place_of
from prefplan.models.kernels import INFINITE, UNREACHABLE, Integer, bare_kernel
from prefplan.preferences.objective import PreferenceObjective
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
    """Tables for B blocks of at most k tasks; those of one preference are disjoint.

    Attributes:
        sets: the blocks. members: (B,) int64, as bits, the tasks that do not count as satisfied outside each.
        owner: (B,) int64, the preference of each.
        base: (B, N + 1) int64, where the table of each begins for a number of tasks satisfied outside.
        table: (entries,) int64, units of mu.
    """

    sets: TaskSets
    members: np.ndarray
    owner: np.ndarray
    base: np.ndarray
    table: np.ndarray


class PreferenceBlock(NamedTuple):
    """One block: the preference it is for, its tasks, `Blocks.members`, and its table for each number outside."""

    owner: int
    tasks: tuple[int, ...]
    members: int
    tables: list[np.ndarray]


def blocks(
    backwards: Sequence[Backward | ProjectedBackward], preferences: Mapping[int, PreferenceObjective], known: Patterns
) -> Blocks:
    """Return the tables of preferences, by number; none for one whose growth has no bound but 0.

    Args:
        backwards: (D,) what fills tables of each cost.
        preferences: those whose growth is bounded.
        known: costs-to-go, of which those of single tasks are reused.
    """
    found = [block for k, o in preferences.items() for block in _blocks(k, o, backwards[o.cost], known)]
    tasks = len(backwards[0].sizes)
    base, tables, begin = np.zeros((len(found), tasks + 1), dtype=np.int64), [np.zeros(0, dtype=np.int64)], 0
    for b, block in enumerate(found):
        for outside, table in enumerate(block.tables):
            if not outside or table is not block.tables[outside - 1]:
                tables.append(table)
                begin += len(table)
            base[b, outside] = begin - len(table)
    members, owner = np.array([(block.members, block.owner) for block in found], dtype=np.int64).reshape(-1, 2).T
    sets, _ = task_sets(backwards[0], [block.tasks for block in found])
    return Blocks(sets, members.copy(), owner.copy(), base, np.concatenate(tables))


def _blocks(
    owner: int, preference: PreferenceObjective, backward: Backward | ProjectedBackward, known: Patterns
) -> Iterator[PreferenceBlock]:
    """Yield the blocks of a preference in which mu grows."""
    measure, n = preference.measure, preference.measure.tasks
    orders = [rate.groups for rate in measure.rate_terms if isinstance(rate, OrderRate)]
    named = set(range(n)).intersection(*({i for group in order for i in group} for order in orders))
    groups = (*(orders or [()])[0], *((i,) for i in range(n) if not orders or i not in chain(*orders[0])))
    for tasks in _split(backward, groups):
        done = np.array([sum(1 << i for j, i in enumerate(tasks) if s >> j & 1) for s in range(2 ** len(tasks))])
        each = [
            measure.rates(done, frozenset(tasks), outside, preference.units.factor)
            for outside in range(n - len(tasks) + 1)
        ]
        if any(rates.any() for rates in each):
            table_of: dict[bytes, np.ndarray] = {}
            for rates in each:
                if rates.tobytes() not in table_of:
                    table_of[rates.tobytes()] = _growths(backward, tasks, rates, preference.cost, known)
            # Only tasks that every order names count as satisfied outside: a smaller number is still admissible.
            members = sum(1 << i for i in range(n) if i in tasks or i not in named)
            yield PreferenceBlock(owner, tasks, members, [table_of[rates.tobytes()] for rates in each])


def _growths(
    backward: Backward | ProjectedBackward, tasks: tuple[int, ...], rates: np.ndarray, cost: int, known: Patterns
) -> np.ndarray:
    """Return the table of a block for its (2^k,) rates."""
    if len(tasks) > 1 or known.sets.tasks.shape[1] > 1 or not len(known.base) or known.add_up:
        return backward.cost_to_go(tasks, rates, shift=backward.shift)
    # For a single task, mu grows at one rate until the task is satisfied.
    [i], rate = tasks, int(rates[0])
    entries = backward.nodes_of(tasks) * int(backward.sizes[i])
    costs = known.table[cost, known.base[i] :][:entries].astype(np.int64)
    growth = np.minimum(costs >> backward.shift, (INFINITE - 1) // max(rate, 1)) * rate
    return np.where(costs < UNREACHABLE, growth, INFINITE)


def _split(backward: Backward | ProjectedBackward, groups: tuple[tuple[int, ...], ...]) -> list[tuple[int, ...]]:
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
def growth_bound(
    tables: Blocks,
    projections: ProjectionArrays | None,
    node: Integer,
    automata: np.ndarray,
    satisfied: Integer,
    preference: Integer,
) -> Integer:
    """Return a lower bound, at most INFINITE, of how much a preference grows from a product state to the end."""
    bound = np.int64(0)
    for b in range(tables.members.shape[0]):
        if tables.owner[b] == preference:
            outside, rest = 0, satisfied & ~tables.members[b]
            while rest:
                rest &= rest - 1
                outside += 1
            place = place_of(projections, tables.sets.projection, b, node)
            entry = tables.base[b, outside] + table_entry(tables.sets, b, place, automata)
            bound = min(bound + tables.table[entry], np.int64(INFINITE))
    return bound
