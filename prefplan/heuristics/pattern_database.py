"""Lower bounds tabulated for a few tasks at a time: of the cost-to-go (equation 4), and of how preferences grow.

The max-min heuristic is h(p) = max_j d_j(s, q_j), with d_j the least cost of satisfying task j alone. With sets K of
tasks, h(p) = max_K d_K(s, q_K) is at least as large if every task is in a set (pattern databases). Both are consistent:
every edge of the product maps onto an edge of T x A_K with the same cost, d_K is an exact distance there (or the
consistent bound of `sweep`), and a maximum of consistent bounds is consistent.

Along an edge, mu grows by a rate times the edge's cost; the rate depends on the set of satisfied tasks. For weighted
sums and spreads, the part of the rate that is due to a set of tasks depends on these tasks alone. Its least growth is
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

SWEPT_ENTRIES = 1_000_000
"""Most entries of a swept table of several tasks: about 10 ms. With 1/4, a plan of 12 tasks takes 4 times as long."""

SEARCHED_ENTRIES = 30_000
"""Most entries of a table of several tasks filled by Dijkstra's algorithm: about 10 ms. With twice as many, plans of 9
and 12 tasks that avoid places take 1.5 and 1.1 times as long; with a third, a front of six tasks on a 30 x 30 grid
takes 1.05 times as long."""

DEEP_ENTRIES = 20_000_000
"""Most entries of a swept table for a long search for one plan, about 0.15 s. Without such tables, plans of 10 and 12
tasks take as long in the median, but one plan in seven takes 13 and 2 times as long, respectively."""

ENTRIES = 60_000_000
"""Most entries of all tables of several tasks: sweeping them takes 0.4 s."""

GROWTH_TASKS = 3
"""Most tasks of a table of mu's growth. With four, tables cost more than they save (10 x 10 grids, 7 and 8 tasks)."""

GROWTH_ENTRIES = 5_000
"""Most entries of a table of mu's growth for several tasks. With 200,000, fronts of manipulation models with six or
eight objects take twice as long; with 1, fronts of weighted sums on grids take up to 1.6 times as long."""

ALONE_ENTRIES = 4_000_000
"""Most entries of a table of mu's growth for one task."""


class Tables(NamedTuple):
    """P tables, each for a set of at most k tasks.

    Attributes:
        tasks: (P, k) int64, the tasks of each set, then zeros.
        strides: (P, k) int64, entry = node + sum_j strides[j] q_j; 0 beyond a set's tasks.
        projections: the model's projection that each table is over; None where states are listed.
        objective: (P,) int64, the cost or preference that each table bounds.
        base: (P,) int64, where each table begins in `table`.
        table: (entries,) int32, in units, cut off at UNREACHABLE - 1, which keeps bounds consistent.
        costs: number of costs.
        add_up: whether the bound of a cost is the sum of its entries, not the largest; of a preference it always is.
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
    """Return the sets of tasks that get a table of costs: any two tasks share a set, unless tables would be too large.

    Args:
        backward: the product.
        wanted: number of tasks in a set, if there are as many: all sets of this size are returned; None to choose.
        max_entries: most entries of all tables that fit into memory.
        deep: whether the tables are for a long search for one plan.
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
    """Yield tables of the growth of a preference, for sets of neighbouring tasks.

    `objective` is the preference's number, and `backward` is over the cost in which the preference measures tasks.
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
    """Return tables as arrays for the kernels; `backwards` filled the tables of (D,) costs."""
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
    """Return tables with entries times a weight, to be added: they guide a search, and are not admissible."""
    entries = np.minimum((tables.table * weight).astype(np.int64), UNREACHABLE - 1)
    table = np.where(tables.table < UNREACHABLE, entries, UNREACHABLE).astype(np.int32)
    return tables._replace(table=table, add_up=True)


@inner_kernel
def bound_of(tables: Tables, node: Integer, automata: np.ndarray, e: Integer) -> Integer:
    """Return a lower bound, at most INFINITE, of the growth of objective e from a product state to a goal."""
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
