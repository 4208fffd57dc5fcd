"""The max-min heuristic (equation 4) in plain Python: a plan costs at least what each remaining task costs alone.

    h(p) = max over the tasks j not satisfied in p = (s, q_1, ..., q_N) of d_j(s, q_j),

where d_j(s, q) is the least cost in T x A_j until task j is satisfied or skipped (Dijkstra's algorithm, backwards).

Lemma 1: h is admissible. A plan that satisfies all tasks satisfies task j, and every step of the product is a step of
T x A_j of the same cost. For the same reason h is consistent, h(p) <= cost(p, a) + h(p'), so that best-first search
pops labels in order of f. Other files of this folder have larger bounds, and fill the same tables in compiled code.
"""

import heapq
import math
from collections import defaultdict
from collections.abc import Mapping, Sequence

from prefplan.limits import check_limits
from prefplan.product.product_automaton import Product

CHECK_PERIOD = 64
"""States, or labels of a search, between two checks of the limits: some milliseconds at most."""

Distances = Mapping[tuple[int, int], int]
"""d_j by (s, q); (s, q) is missing if task j cannot be satisfied from there."""


def max_min(distances: Sequence[Distances], state: Sequence[int]) -> float:
    """Return h(p) (equation 4), an integer, or infinity if some task cannot be satisfied any more.

    Args:
        distances: (N,) d_j of every task; 0 where task j is satisfied or skipped.
        state: p = (s, q_1, ..., q_N, ...).
    """
    s, *automata = state
    return max(d.get((s, q), math.inf) for d, q in zip(distances, automata, strict=False))


def task_distances(product: Product, costs: Sequence[int]) -> list[Distances]:
    """Return (N,) d_j of all tasks for one of the costs, given as (E,) costs of the edges.

    Raises:
        LimitError: a limit was reached.
    """
    system = product.listed
    into: Mapping[int, list[tuple[int, int]]] = defaultdict(list)
    for state in range(system.size):
        if state % CHECK_PERIOD == 0:
            check_limits()
        for edge in system.edges(state):
            into[int(system.targets[edge])].append((state, costs[edge]))
    return [_distances(product, task, into) for task in range(len(product.automata))]


def _distances(product: Product, task: int, into: Mapping[int, list[tuple[int, int]]]) -> Distances:
    """Return d_j of one task, given the predecessors of every state of T with the cost from each."""
    dfa, classes = product.automata[task], product.graph.classes.tolist()
    before: Mapping[tuple[int, int], list[int]] = defaultdict(list)
    for q in range(dfa.size):
        for number, label in enumerate(product.class_sets):
            for reading in dfa.readings(q, label):
                before[reading.state, number].append(q)
    least: dict[tuple[int, int], int] = {}
    ends = [q for q in (dfa.automaton.accepting, dfa.skipped) if q is not None]
    waiting = [(0, s, q) for q in ends for s in range(len(classes))]
    while waiting:
        distance, s, q = heapq.heappop(waiting)
        if (s, q) in least:
            continue
        least[s, q] = distance
        if len(least) % CHECK_PERIOD == 0:
            check_limits()
        for source, cost in into[s]:
            for q_before in before[q, classes[s]]:
                heapq.heappush(waiting, (distance + cost, source, q_before))
    return least
