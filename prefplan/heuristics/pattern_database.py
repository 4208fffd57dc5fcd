"""Lower bounds tabulated for a few tasks at a time: of the cost-to-go (equation 4), and of how preferences grow.

The max-min heuristic is h(p) = max_j d_j(s, q_j), with d_j the least cost of satisfying task j alone. With sets K of
tasks, h(p) = max_K d_K(s, q_K) is at least as large if every task is in one (pattern databases). Both are consistent:
every edge of the product maps onto an edge of T x A_K with the same cost, d_K is an exact distance there, and a maximum
of consistent bounds is consistent.

A preference value grows by a rate times the cost, which depends on which tasks are satisfied. The part of the rate
that is due to a set of tasks depends on these alone for weighted sums and spreads; the least sum of it times cost is
tabulated in the same way, for disjoint sets, whose bounds are added. Orders are left out: for them this saves nothing.

The table of a set K has an entry for every node and every combination of the states of K's automata.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.backward import Backward
from prefplan.heuristics.projected_backward import ProjectedBackward
from prefplan.heuristics.projection import ProjectionArrays, arrays_of, place_of
from prefplan.models.kernels import INFINITE, UNREACHABLE, Integer, inner_kernel
from prefplan.preferences.objective import Measure
from prefplan.preferences.terms import OrderRate, WeightedRate

SWEPT_ENTRIES, SEARCHED_ENTRIES = 1_000_000, 30_000
"""Most entries of a table of several tasks, if it is swept or filled by Dijkstra: either takes about 10 ms. With a
fourth of the first, a plan of 12 tasks takes four times as long; with twice the second, plans of 9 and 12 tasks that
avoid places 1.5 and 1.1 times; with a third, a front of six tasks on a 30 x 30 grid 1.05 times."""

DEEP_ENTRIES = 20_000_000
"""Most entries of a swept table for a long search for one plan, about 0.15 s. Without such tables plans of 10 and 12
tasks take as long in the median, but one in seven 13 and 2 times as long."""

ENTRIES = 60_000_000
"""Most entries of all tables of several tasks: sweeping them takes 0.4 s."""

GROWTH_TASKS, GROWTH_ENTRIES = 3, 5_000
"""Most tasks of a table of a preference's growth, and most entries of one of several tasks. With four tasks, tables
cost more than they save (10 x 10 grids, 7 and 8 tasks); with 200,000 entries, fronts of manipulation models with six or
eight objects take twice as long; with 1, those of weighted sums on grids up to 1.6 times."""

ALONE_ENTRIES = 4_000_000
"""Most entries of a table of a preference's growth because of one task."""


class Tables(NamedTuple):
    """P tables, each for a set of at most k tasks.

    Attributes:
        tasks: (P, k) int64. strides: (P, k) int64: entry = node + sum_j strides[j] q_j. Both are 0 beyond a set's
            tasks.
        projections: of the model, which tables are over; None where states are listed.
        objective: (P,) int64, the cost or preference that each bounds.
        base: (P,) int64, where each begins.
        table: (entries,) int32, in units, cut off at UNREACHABLE - 1, which keeps bounds consistent.
        costs: number of costs.
        add_up: whether a cost's bound is the sum of the entries, not the largest; a preference's always is.
    """

    tasks: np.ndarray
    strides: np.ndarray
    projections: ProjectionArrays | None
    objective: np.ndarray
    base: np.ndarray
    table: np.ndarray
    costs: int
    add_up: bool


class TableOf(NamedTuple):
    """One table: (entries,) int32, of an objective, for a set of tasks."""

    objective: int
    tasks: tuple[int, ...]
    entries: np.ndarray


def sets_of_tasks(
    backward: Backward, wanted: int | None, max_entries: float, *, deep: bool = False
) -> list[tuple[int, ...]]:
    """Return the sets of tasks to fill tables of costs for: any two share one, unless these would be too large.

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


def joined_groups(tasks: int, groups: int) -> list[tuple[int, ...]]:
    """Return sets such that any two tasks share one: tasks are dealt into groups, and every two groups make a set."""
    dealt = [range(g, tasks, groups) for g in range(groups)]
    return [tuple(sorted((*one, *other))) for one, other in combinations(dealt, 2)]


def growth_tables(objective: int, preference: Measure, backward: Backward | ProjectedBackward) -> Iterator[TableOf]:
    """Yield tables of how a preference, the objective of that number, grows, for sets of tasks that are neighbours.

    They are filled by `backward`, over the cost in which it measures tasks.
    """
    rates = [rate for rate in preference.rate_terms if not isinstance(rate, OrderRate)]
    for tasks in _neighbours(backward) if rates else ():
        due = [rate for rate in rates if isinstance(rate, WeightedRate) or rate.members.issubset(tasks)]
        factors = preference.rates(due, tasks)
        if factors.any():
            yield TableOf(objective, tasks, backward.cost_to_go(tasks, factors))


def _neighbours(backward: Backward | ProjectedBackward) -> list[tuple[int, ...]]:
    """Return disjoint sets of neighbouring tasks; tasks with too large tables are in none."""
    sets: list[tuple[int, ...]] = []
    for i in range(len(backward.sizes)):
        joined = (sets[-1] if sets else ()) + (i,)
        if sets and len(joined) <= GROWTH_TASKS and backward.entries_of(joined) <= GROWTH_ENTRIES:
            sets[-1] = joined
        elif backward.entries_of((i,)) <= ALONE_ENTRIES:
            sets.append((i,))
    return sets


def joined_tables(backwards: Sequence[Backward | ProjectedBackward], each: Sequence[TableOf]) -> Tables:
    """Return tables as arrays for the kernels, given what filled those of (D,) costs."""
    first = backwards[0]
    tasks, strides = np.zeros((2, len(each), max((len(one.tasks) for one in each), default=1)), dtype=np.int64)
    for p, one in enumerate(each):
        combinations = np.cumprod([1, *first.sizes[list(one.tasks)]])
        tasks[p, : len(one.tasks)] = one.tasks
        strides[p, : len(one.tasks)] = len(one.entries) // combinations[-1] * combinations[:-1]
    projections = None
    if isinstance(first, ProjectedBackward) and each:
        projections = arrays_of([first.projection(one.tasks) for one in each], first.space)
    ends = np.cumsum([len(one.entries) for one in each], dtype=np.int64)
    return Tables(
        tasks,
        strides,
        projections,
        np.array([one.objective for one in each], dtype=np.int64),
        np.concatenate([np.zeros(1, np.int64), ends])[: len(each)],
        np.concatenate([np.zeros(0, np.int32), *(one.entries for one in each)]),
        len(backwards),
        projections is not None,
    )


def scaled(tables: Tables, weight: float) -> Tables:
    """Return tables of the costs times a weight, to be added: they guide a search, and are not admissible."""
    entries = np.minimum((tables.table * weight).astype(np.int64), UNREACHABLE - 1)
    table = np.where(tables.table < UNREACHABLE, entries, UNREACHABLE).astype(np.int32)
    return tables._replace(table=table, add_up=True)


@inner_kernel
def bound_of(tables: Tables, node: Integer, automata: np.ndarray, e: Integer) -> Integer:
    """Return a lower bound, at most INFINITE, of what an objective grows by from a product state to the end."""
    bound, adds = np.int64(0), tables.add_up or e >= tables.costs
    for p in range(tables.base.shape[0]):
        if tables.objective[p] == e:
            more = _entry(tables, place_of(tables.projections, p, node), automata, p)
            bound = min(bound + more, np.int64(INFINITE)) if adds else max(bound, more)
    return bound


@inner_kernel
def _entry(tables: Tables, node: Integer, automata: np.ndarray, p: Integer) -> np.int64:
    """Return the entry of table p; `node` is that of the table's projection."""
    entry = tables.base[p] + node
    for j in range(tables.tasks.shape[1]):
        entry += tables.strides[p, j] * automata[tables.tasks[p, j]]
    value = np.int64(tables.table[entry])
    return np.int64(INFINITE) if value == UNREACHABLE else value
