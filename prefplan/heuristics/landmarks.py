"""Lower bounds of the cost-to-go by landmarks and minimum spanning trees, as in the travelling salesman problem.

A *landmark* of a product state is a set of nodes: every run from the state to a goal reads the label of at least one
of them (J. Hoffmann, J. Porteous and L. Sebastia, "Ordered landmarks in planning", JAIR 2004). A plan is a path from
the state's node through all landmarks. So it costs at least as much as a minimum spanning tree over the least costs
between these sets. Multipliers, one for each set, make the tree more like a path, on which every set but the ends has
two neighbours (M. Held and R. M. Karp, "The traveling-salesman problem and minimum spanning trees", 1970): they are
computed for the start, and give a bound everywhere.

Where many tasks are left, this bound exceeds those of sets of a few tasks (`pattern_database`), and its tables are no
larger than the graph. It is admissible, but need not be consistent.
"""

from typing import NamedTuple

import numpy as np

from prefplan.heuristics.backward import steps_of
from prefplan.limits import check_limits
from prefplan.models.kernels import INFINITE, Integer, inner_kernel
from prefplan.product.product_automaton import Product
from prefplan.product.space import Graph

MOST_LANDMARKS = 62
"""Most landmarks of a product: they are bits of one machine word."""

LARGEST_AUTOMATON = 100
"""Most states of an automaton whose landmarks are computed: a larger one has more landmarks than there are bits."""

SCALE = 16
"""Factor by which costs are scaled: multipliers, which are integers, are fractions of a unit of cost."""

DISCONNECTED = 2**48
"""Stands for the cost between sets neither of which can be reached from the other; scaled costs are less."""

ROUNDS = 25
"""Number of spanning trees in the subgradient ascent."""

SHRINKING = 0.87
"""Factor by which the step of the ascent shrinks from tree to tree."""

HOPED = 1.15
"""Bound that a step of the ascent aims at, in multiples of the best bound so far."""


class Landmarks(NamedTuple):
    """M sets of the S nodes of a contracted graph. Costs are scaled by `SCALE`.

    Attributes:
        remaining: (N, Q) int64, the landmarks of each automaton's states, as bits.
        between: (M, M) int64, least cost between two sets, in the cheaper direction, plus both multipliers.
        ahead: (S, M) int64, least cost from each node to each set, plus both multipliers.
        price: (M,) int64, multiplier of each set.
        node_price: (S,) int64, multiplier of each node at the start of a path: that of the first set which has it.
        least: (M,) int64, scratch.
        order: (M,) int64, scratch.
    """

    remaining: np.ndarray
    between: np.ndarray
    ahead: np.ndarray
    price: np.ndarray
    node_price: np.ndarray
    least: np.ndarray
    order: np.ndarray


NO_LANDMARKS = Landmarks(*np.zeros((3, 0, 0), np.int64), *np.zeros((4, 0), np.int64))
"""No landmarks; of the same type as others, so that the search is compiled only once."""


def landmarks(product: Product, graph: Graph) -> Landmarks:
    """Return the landmarks of a product over a contracted graph; none if costs are too large."""
    least = graph.least
    if not product.starts or ((least < INFINITE) & (least >= DISCONNECTED // SCALE)).any():
        return NO_LANDMARKS
    remaining, sets = _sets(product, graph)
    if not sets:
        return NO_LANDMARKS
    costs = np.where(least < INFINITE, least * SCALE, DISCONNECTED)
    ahead = np.ascontiguousarray(np.array([costs[:, nodes].min(axis=1) for nodes in sets]).T)
    between = np.array([ahead[nodes].min(axis=0) for nodes in sets])
    member = np.array([np.isin(np.arange(len(least)), nodes) for nodes in sets])
    between = np.where(member @ member.T, 0, np.minimum(between, between.T))
    price, node_price = np.zeros(len(sets), dtype=np.int64), np.zeros(len(least), dtype=np.int64)
    codes = [start.automata[: len(remaining)] for start in product.starts]
    at_start = max((int(np.bitwise_or.reduce(remaining[np.arange(len(q)), q])) for q in codes), key=int.bit_count)
    needed = [m for m in range(len(sets)) if at_start >> m & 1]
    if needed:
        distances = np.zeros((1 + len(needed), 1 + len(needed)), dtype=np.int64)
        distances[0, 1:] = distances[1:, 0] = ahead[graph.start, needed]
        distances[1:, 1:] = between[np.ix_(needed, needed)]
        ascended = multipliers(distances)
        node_price[graph.start], price[needed] = ascended[0], ascended[1:]
    for m, nodes in reversed(list(enumerate(sets))):
        node_price[nodes] = price[m]
    between, ahead = between + price + price[:, None], ahead + node_price[:, None] + price
    return Landmarks(remaining, between, ahead, price, node_price, *np.zeros((2, len(sets)), dtype=np.int64))


def multipliers(costs: np.ndarray) -> np.ndarray:
    """Return (n,) multipliers for paths from the first of n sets, by subgradient ascent, given (n, n) costs."""
    exact, best, highest, step = np.zeros(len(costs)), np.zeros(len(costs), dtype=np.int64), -1.0, 1.0
    for _ in range(ROUNDS):
        price = np.rint(exact).astype(np.int64)
        total, excess = _spanning_tree(costs + price + price[:, None])
        # Count a path's end as joined to its start: then every set has two neighbours on a path.
        end = 1 + int(price[1:].argmin())
        excess[[0, end]] += 1
        bound = float(total - 2 * price.sum() + price[0] + price[end])
        if bound > highest:
            highest, best = bound, price
        excess -= 2
        if highest >= DISCONNECTED / 2 or not excess.any():
            break
        exact += step * max(HOPED * highest - bound, 1.0) / (excess @ excess) * excess
        step *= SHRINKING
    return best


def _spanning_tree(costs: np.ndarray) -> tuple[int, np.ndarray]:
    """Return the cost of a minimum spanning tree and the number of neighbours of each node (Prim's algorithm)."""
    least, nearest, total = costs[0].copy(), np.zeros(len(costs), dtype=np.int64), 0
    neighbours, is_outside = np.zeros(len(costs), dtype=np.int64), np.arange(len(costs)) > 0
    while is_outside.any():
        added = np.where(is_outside, least, INFINITE).argmin()
        total += int(least[added])
        neighbours[[added, nearest[added]]] += 1
        is_outside[added] = False
        closer = costs[added] < least
        least[closer], nearest[closer] = costs[added, closer], added
    return total, neighbours


def _sets(product: Product, graph: Graph) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return (N, Q) the landmarks of each automaton's states as bits, and the nodes of each landmark."""
    tasks, (_, most, labels) = len(product.sizes), product.tables.delta.shape
    met = np.isin(np.arange(labels), graph.classes)
    numbers: dict[frozenset[int], int] = {}
    remaining = np.zeros((tasks, most), dtype=np.int64)
    for i, size in enumerate(product.sizes.tolist()):
        if size > LARGEST_AUTOMATON:
            continue
        leads = _leads(product, i) & met
        ends = np.isin(np.arange(size), product.tables.ends[i])
        live = ~_without(leads, ends, frozenset())
        # Every run from a state to an end reads a label that leads from this state to another live state.
        onward = leads & (live & ~np.eye(size, dtype=bool))[:, :, None]
        leaving = [frozenset(np.flatnonzero(labels).tolist()) for labels in np.logical_or.reduce(onward, axis=1)]
        needed = {cut: _without(leads, ends, cut) for cut in dict.fromkeys(leaving)}
        for q in np.flatnonzero(~ends & live):
            check_limits()
            cuts = [c for c, cut in needed.items() if cut[q]]
            for cut in cuts:
                if any(other < cut for other in cuts):
                    continue
                if cut in numbers or len(numbers) < MOST_LANDMARKS:
                    remaining[i, q] |= 1 << numbers.setdefault(cut, len(numbers))
    return remaining, [np.flatnonzero(np.isin(graph.classes, list(cut))) for cut in numbers]


def _leads(product: Product, i: int) -> np.ndarray:
    """Return (Q, Q, C) whether reading a label class may lead an automaton from one state to another."""
    size, (read, before, after) = int(product.sizes[i]), steps_of(product, i)
    leads = np.zeros((size, size, product.tables.delta.shape[2]), dtype=bool)
    leads[before, after, read] = True
    return leads


def _without(leads: np.ndarray, ends: np.ndarray, avoided: frozenset[int]) -> np.ndarray:
    """Return (Q,) whether no end can be reached from a state if some label classes are never read."""
    check_limits()
    steps = np.delete(leads, list(avoided), axis=2).any(axis=2)
    reached = ends
    while ((now := reached | (steps & reached).any(axis=1)) != reached).any():
        reached = now
    return ~reached


@inner_kernel
def landmark_bound(marks: Landmarks | None, node: Integer, automata: np.ndarray) -> Integer:
    """Return a lower bound of the cost-to-go of a product state; `INFINITE` if not all landmarks can be visited."""
    if marks is None:
        return np.int64(0)
    bits = np.int64(0)
    for i in range(marks.remaining.shape[0]):
        bits |= marks.remaining[i, automata[i]]
    if bits == 0:
        return np.int64(0)
    bound = _tree_bound(marks, node, bits)
    if bound >= DISCONNECTED // 2:
        return np.int64(INFINITE)
    return np.int64(max(0, (bound + SCALE - 1) // SCALE))


@inner_kernel
def _tree_bound(marks: Landmarks, node: Integer, bits: Integer) -> Integer:
    """Return the scaled bound by a minimum spanning tree over a node and some landmarks (Prim's algorithm)."""
    count, best, m = 0, 0, 0
    total, cheapest = -marks.node_price[node], np.int64(DISCONNECTED)
    while bits:
        if bits & 1:
            marks.order[count], marks.least[count] = m, marks.ahead[node, m]
            if marks.least[count] < marks.least[best]:
                best = count
            total -= 2 * marks.price[m]
            cheapest = min(cheapest, marks.price[m])
            count += 1
        bits >>= 1
        m += 1
    # Landmarks outside the tree stay at the front of `order`.
    while count:
        total += marks.least[best]
        added = marks.order[best]
        count -= 1
        marks.order[best], marks.least[best] = marks.order[count], marks.least[count]
        best = 0
        for k in range(count):
            marks.least[k] = min(marks.least[k], marks.between[added, marks.order[k]])
            if marks.least[k] < marks.least[best]:
                best = k
    return total + cheapest
