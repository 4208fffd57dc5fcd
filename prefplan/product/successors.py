"""Successors of product states."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.models.manipulation.successors import pack, write_steps
from prefplan.product.kernels import NO_EDGE, Integer, bare_kernel
from prefplan.product.moves import Digits, scratch_digits
from prefplan.product.product_view import ProductView, decode


class Successors(NamedTuple):
    """Output and scratch buffers for successor generation.

    Attributes:
        code: (M,) int64, product state reached.
        cost: (M,) int64, cost of the step.
        violation: (M, P) int64, violation costs that the step pays.
        automata: (N + R,) int64, the automaton states of the expanded state.
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


def successor_buffer(view: ProductView, least: int) -> Successors:
    """Return buffers for the successors of any state, of length at least `least`."""
    nodes, tasks = len(view.classes), len(view.ends)
    most = nodes if view.macro else int(np.diff(view.offsets).max(initial=0))
    if view.generated:
        most = len(scratch_digits(view.moves).steps.actions)
    if view.relaxed:
        readings = np.diff(view.extra_first, axis=2).max(axis=1) + 1
        most *= int(readings.prod(axis=0).max())
    most = max(most, least)
    scratch = nodes if view.macro else 1
    return Successors(
        code=np.empty(most, np.int64),
        cost=np.empty(most, np.int64),
        violation=np.zeros((most, tasks + len(view.tolls)), np.int64),
        automata=np.empty(len(view.sizes), np.int64),
        distance=np.empty(scratch, np.int64),
        via=np.empty(scratch, np.int64),
        choice=np.empty(tasks, np.int64),
        digits=scratch_digits(view.moves),
    )


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
    found: Integer = 0
    for k in range(write_steps(view.moves, node, buffer.digits.steps)):
        found = _read_generated(view, k, node, buffer, found)
    return found


@bare_kernel
def _read_generated(view: ProductView, k: Integer, node: Integer, buffer: Successors, found: Integer) -> Integer:
    """Write the product state after reading the label of the k-th generated state, and return the new count."""
    digits, cost = buffer.digits.steps.digits[k], view.costs[buffer.digits.steps.prices[k]]
    if cost < 0:
        buffer.digits.unmeasured[0] = node
        return found
    code = pack(view.moves, digits)
    for i in range(buffer.automata.shape[0]):
        letter = np.int64(0)
        for d in range(digits.shape[0]):
            letter += view.letters[i, d, digits[d]]
        jump = view.jump[i, buffer.automata[i], letter]
        if jump < 0:
            return found
        _pay_toll(view, i, letter, buffer, found)
        code += jump
    buffer.code[found] = code
    buffer.cost[found] = cost
    return found + 1


@bare_kernel
def _pay_toll(view: ProductView, i: Integer, letter: Integer, buffer: Successors, found: Integer) -> None:
    """Write the violation cost of a rule that may be broken, for reading a class or letter."""
    if view.pays and i < buffer.violation.shape[1]:
        tasks = view.ends.shape[0]
        buffer.violation[found, i] = 0 if i < tasks else view.tolls[i - tasks, buffer.automata[i], letter]


@bare_kernel
def _macro_moves(view: ProductView, node: Integer, buffer: Successors) -> Integer:
    """Write the macro-moves: to every node that changes some automaton, by least cost through nodes that change none.

    Exact: no automaton moves before the last node, so the set of satisfied tasks stays the same, and mu depends only on
    the path's cost. Only nodes in `through` lie on paths cheaper than an edge, so no others are tried.
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
    """Write some nodes and the least costs of reaching them through one another (Dijkstra), and return how many."""
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
    label, code = view.classes[node], np.int64(node)
    for i in range(buffer.automata.shape[0]):
        jump = view.jump[i, buffer.automata[i], label]
        if jump < 0:
            return found
        _pay_toll(view, i, label, buffer, found)
        code += jump
    buffer.code[found] = code
    buffer.cost[found] = cost
    return _read_bought(view, label, buffer, found) if view.relaxed else found + 1


@bare_kernel
def _read_bought(view: ProductView, label: Integer, buffer: Successors, found: Integer) -> Integer:
    """Write, after the state of the free reading, those of all others, and return the new count."""
    tasks, first = buffer.choice.shape[0], found
    rest = buffer.code[first]
    for i in range(tasks):
        buffer.choice[i] = 0
        rest -= view.jump[i, buffer.automata[i], label]
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
        code = rest
        for i in range(tasks, buffer.violation.shape[1]):
            buffer.violation[found, i] = buffer.violation[first, i]
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
        buffer.cost[found] = buffer.cost[first]
