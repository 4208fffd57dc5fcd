"""Successors of product states."""

from typing import NamedTuple

import numpy as np

from prefplan.models.kernels import NO_EDGE, Integer, inner_kernel
from prefplan.models.manipulation.successors import pack, write_steps
from prefplan.product.space import Automata, Edges, Generated, Shortcuts, Space, decode


class Successors(NamedTuple):
    """Output and scratch buffers for successor generation.

    Attributes:
        code: (M,) int64, product state reached.
        step: (M,) int64, the number of the step's edge, or of its price where states are generated, or its cost where
            the graph is contracted.
        violation: (M, P) int64, violation costs that the step pays.
        automata: (N + R,) int64, the automaton states of the expanded state.
    """

    code: np.ndarray
    step: np.ndarray
    violation: np.ndarray
    automata: np.ndarray


def successor_buffer(space: Space, least: int) -> Successors:
    """Return buffers for the successors of any state, of length at least `least`."""
    automata, most = space.automata, least
    if space.edges is not None:
        most = int(np.diff(space.edges.offsets).max(initial=0))
    if space.shortcuts is not None:
        most = len(space.shortcuts.near)
    if space.generated is not None:
        most = len(space.generated.steps.actions)
    readings = np.diff(automata.first_relaxed, axis=2).max(axis=1) + 1
    most = max(most * int(readings.prod(axis=0).max()), least)
    return Successors(
        code=np.empty(most, np.int64),
        step=np.empty(most, np.int64),
        violation=np.zeros((most, len(automata.tolls)), np.int64),
        automata=np.empty(len(automata.sizes), np.int64),
    )


@inner_kernel
def successors(
    automata: Automata,
    edges: Edges | None,
    shortcuts: Shortcuts | None,
    generated: Generated | None,
    code: Integer,
    buffer: Successors,
) -> Integer:
    """Write all successors of a product state and return how many there are.

    The compiler knows which arguments are None, and keeps one branch only.
    """
    node = decode(automata, code, buffer.automata)
    count: Integer = np.int64(0)
    if edges is not None:
        for edge in range(edges.offsets[node], edges.offsets[node + 1]):
            target = np.int64(edges.targets[edge])
            label = np.int64(edges.classes[target])
            count = _read(automata, None, None, target, label, np.int64(edge), buffer, count)
    if shortcuts is not None:
        count = _macro_moves(automata, shortcuts, node, buffer)
    if generated is not None:
        count = _generate(automata, generated, node, buffer)
    return count


@inner_kernel
def _generate(automata: Automata, model: Generated, node: Integer, buffer: Successors) -> Integer:
    """Write the successors of a state of a manipulation model, in the order of its actions."""
    count: Integer = np.int64(0)
    for k in range(write_steps(model.moves, node, model.steps)):
        price = model.steps.prices[k]
        if model.costs[price] >= 0:
            digits = model.steps.digits[k]
            code = pack(model.moves, digits)
            count = _read(automata, model.letters, digits, code, np.int64(0), price, buffer, count)
    return count


@inner_kernel
def _macro_moves(automata: Automata, shortcuts: Shortcuts, node: Integer, buffer: Successors) -> Integer:
    """Write the macro-moves: to every node that changes some automaton, by least cost through nodes that change none.

    Exact: no automaton moves before the last node, so the set of satisfied tasks stays the same, and mu depends only on
    the path's cost (Dijkstra's algorithm).
    """
    near, distance, one = shortcuts.near, shortcuts.distance, np.uint64(1)
    stops = np.uint64(0)
    for i in range(buffer.automata.shape[0]):
        stops |= shortcuts.active[i, buffer.automata[i]]
    for v in range(near.shape[0]):
        distance[v] = near[node, v]
    passable, via = ~stops, node
    while via >= 0:
        via = -1
        for v in range(near.shape[0]):
            if passable >> np.uint64(v) & one and distance[v] < (NO_EDGE if via < 0 else distance[via]):
                via = v
        if via >= 0:
            passable &= ~(one << np.uint64(via))
            for v in range(near.shape[0]):
                distance[v] = min(distance[v], distance[via] + near[via, v])
    count: Integer = np.int64(0)
    for v in range(near.shape[0]):
        if stops >> np.uint64(v) & one and distance[v] < NO_EDGE:
            label, cost = np.int64(shortcuts.classes[v]), np.int64(distance[v])
            count = _read(automata, None, None, np.int64(v), label, cost, buffer, count)
    return count


@inner_kernel
def _read(
    automata: Automata,
    letters: np.ndarray | None,
    digits: np.ndarray | None,
    node: Integer,
    label: Integer,
    step: Integer,
    buffer: Successors,
    first: Integer,
) -> Integer:
    """Write the states after reading a node's label, one for each way to read it, and return the new count.

    A generated node has no label: each automaton reads a letter that follows from the node's digits. Each relaxed
    reading of an automaton copies all states that the readings of the automata before have made.
    """
    end = first + 1
    buffer.code[first], buffer.step[first] = node, step
    for i in range(buffer.automata.shape[0]):
        q, free = buffer.automata[i], end
        if letters is not None and digits is not None:
            label = np.int64(0)
            for d in range(digits.shape[0]):
                label += letters[i, d, digits[d]]
        after, stride = automata.delta[i, q, label], automata.strides[i]
        if after < 0:
            return first
        for reading in range(automata.first_relaxed[i, q, label], automata.first_relaxed[i, q, label + 1]):
            for k in range(first, free):
                buffer.code[end], buffer.step[end] = buffer.code[k] + stride * automata.relaxed[reading, 0], step
                for j in range(i):
                    buffer.violation[end, j] = buffer.violation[k, j]
                buffer.violation[end, i] = automata.relaxed[reading, 1]
                end += 1
        for k in range(first, free):
            buffer.code[k] += stride * after
            if i < automata.tolls.shape[0]:
                buffer.violation[k, i] = automata.tolls[i, q, label]
    return end
