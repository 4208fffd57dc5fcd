"""Bi-objective best-first search for (total cost, mu): BOA* on the product.

C. Hernandez Ulloa et al., "A Simple and Fast Bi-Objective Search Algorithm", ICAPS 2020, as adapted in the paper's
"Pareto Front Computation". Labels are expanded in order of (cost + h, mu); with a consistent h, a label whose mu is
not below the smallest mu expanded so far at its state is dominated by that one. This is exact for preferences whose
contract is `additive` or `convex`. Bounding mu turns it into Algorithm 1.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count

from prefplan.heuristic import Heuristic
from prefplan.preference import Measure
from prefplan.product import Product, State


@dataclass(frozen=True, eq=False)
class Label:
    """One path to a product state.

    Attributes:
        state: where it leads.
        cost: total cost g in quanta (equation 1).
        preference: mu of `task_costs`.
        task_costs: the path's preference cost set (Definition 4): c_i in quanta.
        edge: last edge taken, -1 at the start.
        parent: the path before it.
    """

    state: State
    cost: int
    preference: int
    task_costs: tuple[int, ...]
    edge: int = -1
    parent: Label | None = None


@dataclass
class Statistics:
    """How much work a search did: labels expanded and generated, product states met."""

    expanded: int = 0
    generated: int = 0
    met: set[State] = field(default_factory=set)


def boa_star(
    product: Product,
    measure: Measure,
    heuristic: Heuristic,
    *,
    max_preference: float = math.inf,
    max_cost: float = math.inf,
    statistics: Statistics | None = None,
) -> Iterator[Label]:
    """Yield one path for every non-dominated (cost, mu), in order of rising cost and falling mu.

    Among paths of equal (cost, mu) those of fewer actions come first, then those made first in the model's order.

    Args:
        product: where to search.
        measure: mu, with contract `additive` or `convex`.
        heuristic: consistent lower bound of the cost-to-go.
        max_preference: paths with a larger mu are not considered, in mu's quanta.
        max_cost: paths with a larger total cost are not considered, in quanta.
        statistics: filled while the search runs.
    """
    statistics = statistics or Statistics()
    tasks = range(len(product.delta))
    smallest: dict[State, float] = {}
    best = math.inf
    made = count()
    first = Label(product.start, 0, measure((0,) * len(tasks)), (0,) * len(tasks))
    open_list = [(heuristic(first.state), first.preference, 0, next(made), first)]
    if open_list[0][0] > max_cost or first.preference > max_preference:
        return
    while open_list:
        _, _, length, _, label = heapq.heappop(open_list)
        if label.preference >= min(best, smallest.get(label.state, math.inf)):
            continue
        smallest[label.state] = label.preference
        statistics.expanded += 1
        satisfied = product.satisfied(label.state)
        if all(satisfied):
            best = label.preference
            yield label
            continue
        for edge, step, state in product.successors(label.state):
            cost = label.cost + step
            task_costs = tuple([c if done else c + step for c, done in zip(label.task_costs, satisfied, strict=True)])
            preference = measure(task_costs)
            if preference > max_preference or preference >= min(best, smallest.get(state, math.inf)):
                continue
            estimate = cost + heuristic(state)
            if estimate > max_cost or estimate == math.inf:
                continue
            statistics.generated += 1
            statistics.met.add(state)
            child = Label(state, cost, preference, task_costs, edge, label)
            heapq.heappush(open_list, (estimate, preference, length + 1, next(made), child))
