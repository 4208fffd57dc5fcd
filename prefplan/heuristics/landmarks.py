"""Lower bounds of the cost-to-go by landmarks and minimum spanning trees, as in the travelling salesman problem.

A *landmark* of a product state is a set of nodes of which every run from there to a goal reads at least one (J.
Hoffmann, J. Porteous and L. Sebastia, "Ordered landmarks in planning", JAIR 2004). In the order of first visits, a plan
is a path from the state's node through all of them, so that none costs less than a minimum spanning tree over least
costs between the sets. Multipliers on the sets make the tree more like a path, on which all but the ends have two
neighbours (M. Held and R. M. Karp, "The traveling-salesman problem and minimum spanning trees", 1970): they are
computed for the start, and give a bound everywhere.

Where many tasks are left this bound exceeds those of sets of a few tasks (`pattern_database`), and its tables are no
larger than the graph. It is admissible, but need not be consistent.
"""

from typing import NamedTuple

import numpy as np

from prefplan.heuristics.backward import steps_of
from prefplan.limits import check_limits
from prefplan.models.kernels import INFINITE, Integer, bare_kernel, inner_kernel
from prefplan.product.contraction import Graph
from prefplan.product.product_automaton import Product

MOST_LANDMARKS = 62
"""Landmarks are bits of one machine word."""

LARGEST_AUTOMATON = 100
"""Most states of an automaton whose landmarks are looked for: larger ones have more than there are bits."""

SCALE = 16
"""Multipliers are whole multiples of a unit of cost divided by this."""

DISCONNECTED = 2**48
"""Stands for the cost between sets neither of which can be reached from the other; scaled costs are less."""

ROUNDS, FIRST_STEP, SHRINKING, HOPED = 200, 1.0, 0.98, 1.15
"""Of the ascent: number of trees, length of the first step, the factor by which steps shrink, and the bound that a step
aims at, in multiples of the best yet."""


class Landmarks(NamedTuple):
    """M sets of the S nodes of a contracted graph. Costs are scaled by `SCALE`.

    Attributes:
        remaining: (N, Q) int64, the landmarks of each automaton's states, as bits.
        between: (M, M) int64, least cost between two sets, in the cheaper direction, plus both multipliers.
        ahead: (S, M) int64, least cost from each node to each set, plus both multipliers.
        price: (M,) int64, multipliers. node_price: (S,) int64.
        least: (M,) int64, order: (M,) int64: scratch.
    """

    remaining: np.ndarray
    between: np.ndarray
    ahead: np.ndarray
    price: np.ndarray
    node_price: np.ndarray
    least: np.ndarray
    order: np.ndarray


NO_LANDMARKS = Landmarks(*np.zeros((3, 0, 0), np.int64), *np.zeros((4, 0), np.int64))
"""Of no use. They are of the same type as others, so that the search need not be compiled once more without them."""


class Ascent(NamedTuple):
    """Memory of a subgradient ascent, (M + 1,) each, of the landmarks and then of the start's node.

    Attributes:
        degrees: in a spanning tree; 2 for landmarks that need not be visited.
        exact: multipliers before they are rounded.
        best: int64, the multipliers of the best bound. nearest: int64, scratch.
    """

    degrees: np.ndarray
    exact: np.ndarray
    best: np.ndarray
    nearest: np.ndarray


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
    marks = Landmarks(remaining, between, ahead.copy(), price, node_price, *np.zeros((2, len(sets)), dtype=np.int64))
    codes = [start.automata[: len(remaining)] for start in product.starts]
    at_start = [int(np.bitwise_or.reduce(remaining[np.arange(len(q)), q])) for q in codes]
    ascent = Ascent(*np.zeros((2, len(sets) + 1)), *np.zeros((2, len(sets) + 1), dtype=np.int64))
    ascend(marks, graph.start, max(at_start, key=int.bit_count), ascent)
    for m, nodes in reversed(list(enumerate(sets))):
        node_price[nodes] = price[m]
    return marks._replace(ahead=ahead + node_price[:, None] + price)


def _sets(product: Product, graph: Graph) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return (N, Q) the landmarks of each automaton's states as bits, and the nodes of each landmark."""
    tasks, (_, most, labels) = len(product.sizes), product.delta.shape
    met = np.isin(np.arange(labels), graph.classes)
    numbers: dict[frozenset[int], int] = {}
    remaining = np.zeros((tasks, most), dtype=np.int64)
    for i, size in enumerate(product.sizes.tolist()):
        if size > LARGEST_AUTOMATON:
            continue
        leads = _leads(product, i) & met
        ends = np.isin(np.arange(size), product.ends[i][product.ends[i] >= 0])
        live = ~_without(leads, ends, frozenset())
        # A run from a state to an end reads one of the labels that lead from there to another live state.
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
    leads = np.zeros((size, size, product.delta.shape[2]), dtype=bool)
    leads[before, after, read] = True
    return leads


def _without(leads: np.ndarray, ends: np.ndarray, avoided: frozenset[int]) -> np.ndarray:
    """Return (Q,) whether no end can be reached from a state without reading one of some label classes."""
    check_limits()
    steps = np.delete(leads, list(avoided), axis=2).any(axis=2)
    reached = ends
    while ((now := reached | (steps & reached).any(axis=1)) != reached).any():
        reached = now
    return ~reached


@bare_kernel
def ascend(marks: Landmarks, node: Integer, bits: Integer, ascent: Ascent) -> None:
    """Set the multipliers of the landmarks and a node by subgradient ascent of the node's bound, all 0 at first."""
    count, highest, length = marks.price.shape[0], -1.0, FIRST_STEP
    for _ in range(ROUNDS):
        bound = float(_tree_bound(marks, node, bits, ascent))
        if bound > highest:
            highest = bound
            for m in range(count):
                ascent.best[m] = marks.price[m]
            ascent.best[count] = marks.node_price[node]
        norm = 0.0
        for m in range(count + 1):
            norm += (ascent.degrees[m] - 2.0) ** 2
        if norm == 0.0 or highest >= DISCONNECTED / 2:
            break
        step = length * max(HOPED * highest - bound, 1.0) / norm
        for m in range(count + 1):
            ascent.exact[m] += step * (ascent.degrees[m] - 2.0)
            _set_price(marks, node, m, np.int64(np.rint(ascent.exact[m])))
        length *= SHRINKING
    for m in range(count + 1):
        _set_price(marks, node, m, ascent.best[m])


@inner_kernel
def _set_price(marks: Landmarks, node: Integer, m: Integer, price: Integer) -> None:
    """Set the multiplier of a landmark, or, beyond them, of a node."""
    count = marks.price.shape[0]
    if m == count:
        for k in range(count):
            marks.ahead[node, k] += price - marks.node_price[node]
        marks.node_price[node] = price
        return
    change = price - marks.price[m]
    for k in range(count):
        marks.between[m, k] += change
        marks.between[k, m] += change
    for v in range(marks.node_price.shape[0]):
        marks.ahead[v, m] += change
    marks.price[m] = price


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
    bound = _tree_bound(marks, node, bits, None)
    if bound >= DISCONNECTED // 2:
        return np.int64(INFINITE)
    return np.int64(max(0, (bound + SCALE - 1) // SCALE))


@inner_kernel
def _tree_bound(marks: Landmarks, node: Integer, bits: Integer, ascent: Ascent | None) -> Integer:
    """Return the scaled bound by a minimum spanning tree over a node and some landmarks (Prim's algorithm).

    For an ascent, degrees are written; the path's end counts as joined to its start: all degrees on a path are 2.
    """
    start = marks.price.shape[0]
    count, best, last, m = 0, 0, 0, 0
    total, cheapest = -marks.node_price[node], np.int64(DISCONNECTED)
    if ascent is not None:
        ascent.degrees[:] = 2.0
    while bits:
        if bits & 1:
            marks.order[count], marks.least[count] = m, marks.ahead[node, m]
            if ascent is not None:
                ascent.degrees[m], ascent.nearest[count] = 0.0, start
            if marks.least[count] < marks.least[best]:
                best = count
            total -= 2 * marks.price[m]
            if marks.price[m] < cheapest:
                cheapest, last = marks.price[m], m
            count += 1
        bits >>= 1
        m += 1
    if ascent is not None:
        ascent.degrees[start] = 1.0
        ascent.degrees[last] += 1.0
    # Landmarks outside the tree stay at the front of `order`.
    while count:
        total += marks.least[best]
        added = marks.order[best]
        count -= 1
        if ascent is not None:
            ascent.degrees[added] += 1.0
            ascent.degrees[ascent.nearest[best]] += 1.0
            ascent.nearest[best] = ascent.nearest[count]
        marks.order[best], marks.least[best] = marks.order[count], marks.least[count]
        best = 0
        for k in range(count):
            onward = marks.between[added, marks.order[k]]
            if ascent is not None and onward < marks.least[k]:
                ascent.nearest[k] = added
            marks.least[k] = min(marks.least[k], onward)
            if marks.least[k] < marks.least[best]:
                best = k
    return total + cheapest
