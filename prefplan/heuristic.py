"""Max-min heuristic (equation 4): the exact cost-to-go of each task alone, and the largest of them."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable

from prefplan.product import Product, State

Heuristic = Callable[[State], float]
"""An admissible and consistent lower bound of the cost in quanta from a product state to the goal."""


def zero(state: State) -> float:
    """Return 0: the search without a heuristic."""
    return 0


def max_min(product: Product) -> Heuristic:
    """Return h(p) = max over unsatisfied j of d_j(s, q_j), infinite where a task can no longer be satisfied.

    Admissible by Lemma 1. Consistent, as each d_j is an exact distance in a graph onto which every edge of the product
    maps with its own cost, and a maximum of consistent functions is consistent.
    """
    distances = [distance_to_satisfaction(product, task) for task in range(len(product.delta))]

    def bound(state: State) -> float:
        s = state[0]
        return max(d[q][s] for d, q in zip(distances, state[1:], strict=True))

    return bound


def distance_to_satisfaction(product: Product, task: int) -> list[list[float]]:
    """Return d_j by backward Dijkstra on T x A_j: entry [q][s] is the least cost in quanta, or infinity."""
    system, delta, goal = product.problem.system, product.delta[task], product.accepting[task]
    costs: list[list[float]] = [[math.inf] * system.size for _ in delta]
    if goal is None:
        return costs
    scale = 10 ** (product.problem.decimals - system.decimals)
    incoming: list[list[tuple[int, int]]] = [[] for _ in range(system.size)]
    for s in range(system.size):
        for edge in system.edges(s):
            incoming[system.targets[edge]].append((s, int(system.costs[edge]) * scale))
    before = [[[] for _ in system.label_sets] for _ in delta]  # type: list[list[list[int]]]
    for q, row in enumerate(delta):
        for label, after in enumerate(row):
            if q != goal:
                before[after][label].append(q)
    labels = system.labels.tolist()
    costs[goal] = [0.0] * system.size
    queue: list[tuple[float, int, int]] = [(0, s, goal) for s in range(system.size)]
    while queue:
        cost, s, q = heapq.heappop(queue)
        if cost > costs[q][s]:
            continue
        for q_before in before[q][labels[s]]:
            row = costs[q_before]
            for s_before, step in incoming[s]:
                if cost + step < row[s_before]:
                    row[s_before] = cost + step
                    heapq.heappush(queue, (cost + step, s_before, q_before))
    return costs
