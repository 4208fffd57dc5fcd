"""Flat views of a product for compiled kernels, and how its states lead to one another.

Everything that kernels work on is an integer array, grouped in named tuples. Costs and preference values are whole
multiples of `Product.units`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.product.kernels import Integer, bare_kernel
from prefplan.product.moves import (
    GRASP,
    RELEASE,
    TRANSIT,
    TRANSPORT,
    Digits,
    Moves,
    accepts,
    count_objects,
    free_slot,
    is_clear,
    pack,
    standardize,
    unpack,
)

INFINITE = 2**60
"""Cost-to-go where there is no path. A search that meets a cost as large starts again with Python's integers."""


NO_EDGE = 2**61
"""Cost of an edge that does not exist; more than any finite cost-to-go and an edge together."""


UNBOUNDED = 2**62
"""A bound that no cost or mu reaches: what labels hold and what one step adds are less than 2^61 together."""


class ProductView(NamedTuple):
    """A product (Definition 7) over a graph of S nodes, N tasks, Q automaton states at most and C label classes.

    Attributes:
        offsets: (S + 1,) int64, targets: (E,) int32, costs: (E,) int64: edges by source node.
        classes: (S,) int32, label class of each node.
        sizes: (N,) int64, automaton states, strides: (N,) int64: code = node + sum_i strides[i] * q_i.
        jump: (N, Q, C) int64, strides[i] times the state after the free reading of a class.
        extra_first: (N, Q, C + 1) int32, extra_jump: (X,) int64, extra_price: (X,) int64: the bought readings.
        active: (N, Q) uint64, nodes whose label can change the state of automaton i in q; used by macro-moves only.
        near: (S, S) int64, cost of the edge between two nodes, or NO_EDGE, and through: (S, S) uint64, the nodes that
            lie on cheaper paths between them; used by macro-moves only.
        accepting: (N,) int32, skipped: (N,) int32: those states of each automaton, or -1.
        shift: the low bits of costs, that count actions.
        moves: the model, where its states are generated; there are no edges and classes then.
        nodes: number of nodes, or of integers that stand for states.
        relaxed: whether there are bought readings.
        generated: whether states are generated.
        macro: whether edges are followed through all nodes that change nothing (at most 64 nodes then).
    """

    offsets: np.ndarray
    targets: np.ndarray
    costs: np.ndarray
    classes: np.ndarray
    sizes: np.ndarray
    strides: np.ndarray
    jump: np.ndarray
    extra_first: np.ndarray
    extra_jump: np.ndarray
    extra_price: np.ndarray
    active: np.ndarray
    near: np.ndarray
    through: np.ndarray
    accepting: np.ndarray
    skipped: np.ndarray
    moves: Moves
    nodes: int
    shift: int
    relaxed: bool
    generated: bool
    macro: bool


def active_nodes(view: ProductView) -> np.ndarray:
    """Return (N, S) whether a node's label can change an automaton; empty unless macro-moves are used."""
    if not view.macro:
        return np.zeros((0, 0), dtype=bool)
    bits = np.bitwise_or.reduce(view.active, axis=1)
    nodes = np.arange(len(view.classes), dtype=np.uint64)
    return (bits[:, None] >> nodes[None, :]) & np.uint64(1) > 0


class Successors(NamedTuple):
    """Output and scratch buffers for successor generation.

    Attributes:
        code: (M,) int64, product state reached.
        cost: (M,) int64, cost of getting there.
        violation: (M, N) int64, violation costs paid on the way.
        automata: (N,) int64, the automaton states of the state that is left.
        distance: (S,) int64, via: (S,) int64, choice: (N,) int64 and digits: scratch.
    """

    code: np.ndarray
    cost: np.ndarray
    violation: np.ndarray
    automata: np.ndarray
    distance: np.ndarray
    via: np.ndarray
    choice: np.ndarray
    digits: Digits


@bare_kernel
def decode(view: ProductView, code: Integer, automata: np.ndarray) -> Integer:
    """Write the automaton states of a product state and return its node."""
    rest = code // view.nodes
    for i in range(view.sizes.shape[0]):
        automata[i] = rest % view.sizes[i]
        rest //= view.sizes[i]
    return code % view.nodes


@bare_kernel
def masks(view: ProductView, automata: np.ndarray) -> tuple[Integer, Integer]:
    """Return the set of satisfied tasks, and of those that are satisfied or dropped, as bits."""
    satisfied = done = 0
    for i in range(automata.shape[0]):
        if automata[i] == view.accepting[i]:
            satisfied |= 1 << i
            done |= 1 << i
        elif automata[i] == view.skipped[i]:
            done |= 1 << i
    return satisfied, done


@bare_kernel
def successors(view: ProductView, code: Integer, buffer: Successors) -> Integer:
    """Write all successors of a product state and return how many there are."""
    node = decode(view, code, buffer.automata)
    if view.macro:
        return _macro_moves(view, node, buffer)
    if view.generated:
        return _generate(view, node, buffer)
    found: Integer = 0
    for edge in range(view.offsets[node], view.offsets[node + 1]):
        found = _read(view, view.targets[edge], view.costs[edge], buffer, found)
    return found


@bare_kernel
def _generate(view: ProductView, node: Integer, buffer: Successors) -> Integer:
    """Write the successors of a state of a manipulation model, in the order of its actions."""
    moves, digits = view.moves, buffer.digits
    unpack(moves, node, digits.before)
    held = count_objects(moves, digits.before, digits.counts)
    here, locations = moves.over[digits.before[0]], digits.counts.shape[0]
    found: Integer = 0
    met_empty = False
    for x in range(locations):
        if x == here or (held >= 0 and not accepts(moves, digits.counts, x)):
            continue
        if moves.neutral[x] and digits.counts[x] == 0:
            # All empty neutral locations lead to the same state.
            if met_empty:
                continue
            met_empty = True
        _copy(digits.before, digits.after)
        digits.after[0] = x if held < 0 else moves.above[free_slot(moves, digits.before, x)]
        found = _read_generated(view, TRANSIT if held < 0 else TRANSPORT, buffer, found)
    if here == locations:
        return found
    if held >= 0:
        if accepts(moves, digits.counts, here):
            slot = free_slot(moves, digits.before, here)
            _copy(digits.before, digits.after)
            digits.after[0], digits.after[1 + held] = moves.above[slot], slot
            if moves.mark[here, held]:
                digits.after[moves.mark[here, held]] = 1
            found = _read_generated(view, RELEASE, buffer, found)
    elif is_clear(moves, digits.counts, here):
        for o in range(moves.fixed.shape[0]):
            slot = digits.before[1 + o]
            if moves.location[slot] == here and not moves.fixed[o]:
                _copy(digits.before, digits.after)
                digits.after[0], digits.after[1 + o] = moves.above[slot], moves.location.shape[0] - 1
                found = _read_generated(view, GRASP, buffer, found)
    return found


@bare_kernel
def _copy(source: np.ndarray, target: np.ndarray) -> None:
    for d in range(source.shape[0]):
        target[d] = source[d]


@bare_kernel
def _read_generated(view: ProductView, kind: Integer, buffer: Successors, found: Integer) -> Integer:
    """Write the state after reading the label of the state of some digits, and return the new count."""
    letters, digits, hands = view.moves.letters, buffer.digits.after, view.moves.over.shape[0]
    cost = view.moves.costs[(kind * hands + buffer.digits.before[0]) * hands + digits[0]]
    if cost < 0:
        buffer.digits.unmeasured[0] = pack(view.moves, buffer.digits.before)
        return found
    standardize(view.moves, digits)
    code = pack(view.moves, digits)
    for i in range(buffer.automata.shape[0]):
        letter = np.int64(0)
        for d in range(digits.shape[0]):
            letter += letters[i, d, digits[d]]
        code += view.jump[i, buffer.automata[i], letter]
    buffer.code[found] = code
    buffer.cost[found] = cost
    return found + 1


@bare_kernel
def _macro_moves(view: ProductView, node: Integer, buffer: Successors) -> Integer:
    """Move on to every node that changes some automaton, by least cost through nodes that change none.

    Exact: on the way all automata rest, so the set of satisfied tasks stays, and mu depends on the cost of the way
    only. A path cheaper than the edge between two nodes leads through known nodes, so no others need be looked at.
    """
    nodes = view.nodes
    one = np.uint64(1)
    stops = np.uint64(0)
    for i in range(buffer.automata.shape[0]):
        stops |= view.active[i, buffer.automata[i]]
    through = np.uint64(0)
    for v in range(nodes):
        if (stops >> np.uint64(v)) & one:
            through |= view.through[node, v]
    through &= ~stops
    count: Integer = 0
    if through:
        count = _reach_through(view, node, through, buffer)
    found: Integer = 0
    for v in range(nodes):
        if (stops >> np.uint64(v)) & one:
            cost = view.near[node, v]
            for r in range(count):
                cost = min(cost, buffer.distance[r] + view.near[buffer.via[r], v])
            if cost < NO_EDGE:
                found = _read(view, v, cost, buffer, found)
    return found


@bare_kernel
def _reach_through(view: ProductView, node: Integer, through: Integer, buffer: Successors) -> Integer:
    """Write some nodes and the costs of getting to them by way of one another (Dijkstra), and return how many."""
    count = 0
    for v in range(view.near.shape[0]):
        if (through >> np.uint64(v)) & np.uint64(1):
            buffer.via[count] = v
            buffer.distance[count] = view.near[node, v]
            count += 1
    for settled in range(count):
        best = settled
        for r in range(settled + 1, count):
            if buffer.distance[r] < buffer.distance[best]:
                best = r
        buffer.via[settled], buffer.via[best] = buffer.via[best], buffer.via[settled]
        buffer.distance[settled], buffer.distance[best] = buffer.distance[best], buffer.distance[settled]
        for r in range(settled + 1, count):
            step = view.near[buffer.via[settled], buffer.via[r]]
            buffer.distance[r] = min(buffer.distance[r], buffer.distance[settled] + step)
    return count


@bare_kernel
def _read(view: ProductView, node: Integer, cost: Integer, buffer: Successors, found: Integer) -> Integer:
    """Write the states after reading a node's label, in every way it may be read, and return the new count."""
    buffer.code[found] = node + _free_jump(view.jump, buffer.automata, view.classes[node])
    buffer.cost[found] = cost
    return _read_bought(view, node, cost, buffer, found) if view.relaxed else found + 1


@bare_kernel
def _free_jump(jump: np.ndarray, automata: np.ndarray, label: Integer) -> Integer:
    """Return the automata's part of the code after the free reading of a label class."""
    code = np.int64(0)
    for i in range(automata.shape[0]):
        code += jump[i, automata[i], label]
    return code


@bare_kernel
def _read_bought(view: ProductView, node: Integer, cost: Integer, buffer: Successors, found: Integer) -> Integer:
    """Write, after the state of the free reading, those of all others, and return the new count."""
    label = view.classes[node]
    tasks = buffer.choice.shape[0]
    for i in range(tasks):
        buffer.choice[i] = 0
        buffer.violation[found, i] = 0
    while True:
        found += 1
        i = 0
        while i < tasks:
            q = buffer.automata[i]
            buffer.choice[i] += 1
            if buffer.choice[i] <= view.extra_first[i, q, label + 1] - view.extra_first[i, q, label]:
                break
            buffer.choice[i] = 0
            i += 1
        if i == tasks:
            return found
        code = np.int64(node)
        for i in range(tasks):
            q = buffer.automata[i]
            buffer.violation[found, i] = 0
            if buffer.choice[i] == 0:
                code += view.jump[i, q, label]
            else:
                extra = view.extra_first[i, q, label] + buffer.choice[i] - 1
                code += view.extra_jump[extra]
                buffer.violation[found, i] = view.extra_price[extra]
        buffer.code[found] = code
        buffer.cost[found] = cost
