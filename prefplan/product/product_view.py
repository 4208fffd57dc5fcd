"""A product as arrays for compiled kernels, grouped in named tuples.

Costs and preference values are whole multiples of `Product.units`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.models.manipulation.successors import Moves
from prefplan.product.contraction import Graph, all_pairs_costs
from prefplan.product.kernels import NO_EDGE, Integer, bare_kernel
from prefplan.product.product_automaton import Product


class ProductView(NamedTuple):
    """A product (Definition 7) over a graph of S nodes, with at most Q states of an automaton and C label classes.

    The automata of R rules follow those of N tasks; P tasks and rules have violation costs.

    Attributes:
        offsets: (S + 1,) int64, targets: (E,) int32, costs: (E,) int64: edges by source node.
        classes: (S,) int32, label class of each node.
        sizes: (N + R,) int64, automaton states, strides: (N + R,) int64: code = node + sum_i strides[i] * q_i.
        jump: (N + R, Q, C) int64, strides[i] times the state after the free reading of a class; negative if BARRED.
        tolls: (P - N, Q, C) int64, the price of breaking a rule by reading a class, of the rules that may be broken.
        extra_first: (N, Q, C + 1) int32, extra_jump: (X,) int64, extra_price: (X,) int64: the bought readings.
        active: (N + R, Q) uint64, as bits, nodes whose label can change automaton i in q; 0 unless `macro`.
        near: (S, S) int64, cost of the edge between two nodes, or NO_EDGE, and through: (S, S) uint64, as bits, the
            nodes that lie on cheaper paths between them; empty unless `macro`.
        ends: (N, 2) int32, the accepting and the skipped state of each automaton, or -1.
        shift: number of low bits of costs, which count actions.
        moves: the model, where its states are generated; there are no edges and classes then, and `costs` are by price,
            as in `prefplan.models.manipulation.successors.Steps`.
        letters: (N + R, D, r) int64, what each value of a digit adds to the number of the letter that each automaton
            reads.
        nodes: number of nodes, or of integers that stand for states.
        relaxed: whether there are bought readings.
        pays: whether a step may have a violation cost.
        generated: whether states are generated.
        macro: whether the graph is contracted, so that successors are reached by macro-moves (at most 64 nodes then).
    """

    offsets: np.ndarray
    targets: np.ndarray
    costs: np.ndarray
    classes: np.ndarray
    sizes: np.ndarray
    strides: np.ndarray
    jump: np.ndarray
    tolls: np.ndarray
    extra_first: np.ndarray
    extra_jump: np.ndarray
    extra_price: np.ndarray
    active: np.ndarray
    near: np.ndarray
    through: np.ndarray
    ends: np.ndarray
    moves: Moves
    letters: np.ndarray
    nodes: int
    shift: int
    relaxed: bool
    pays: bool
    generated: bool
    macro: bool


def view(product: Product, graph: Graph) -> ProductView:
    """Return a product over a graph as arrays."""
    nodes = graph.size if graph.contracted else product.nodes
    sizes = np.concatenate([product.sizes, product.rule_sizes])
    strides = np.cumprod([nodes, *sizes])[:-1].astype(np.int64)
    delta, tasks = _joined(product.delta, product.rule_delta), len(product.sizes)
    active = np.zeros(delta.shape[:2], dtype=np.uint64)
    if graph.contracted:
        changes = delta != np.arange(delta.shape[1])[None, :, None]
        changes[:tasks, : product.extra_first.shape[1]] |= np.diff(product.extra_first, axis=2) > 0
        bits = np.uint64(1) << np.arange(graph.size, dtype=np.uint64)
        for i, each in enumerate(changes):
            active[i] = (each[:, graph.classes] * bits).sum(axis=1, dtype=np.uint64)
    near, through = np.zeros((0, 0), dtype=np.int64), np.zeros((0, 0), dtype=np.uint64)
    if graph.contracted:
        near, through = _intermediate(graph)
    owner = np.zeros(len(product.extra_state), dtype=np.int64)
    for i in range(tasks):
        owner[product.extra_first[i, 0, 0] :] = i
    return ProductView(
        offsets=graph.offsets,
        targets=graph.targets,
        costs=graph.costs,
        classes=graph.classes,
        sizes=sizes,
        strides=strides,
        jump=delta * strides[:, None, None],
        tolls=product.tolls,
        extra_first=product.extra_first,
        extra_jump=product.extra_state * strides[owner],
        extra_price=product.extra_price,
        active=active,
        near=near,
        through=through,
        ends=product.ends,
        moves=product.moves,
        letters=product.letters,
        nodes=nodes,
        shift=product.shift,
        relaxed=product.relaxed,
        pays=product.relaxed or len(product.tolls) > 0,
        generated=len(product.moves.radices) > 0,
        macro=graph.contracted,
    )


def _joined(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return two tables, (n, Q, C) and (m, Q', C'), as one, with zeros where one of them is narrower."""
    width = np.maximum(one.shape[1:], other.shape[1:])
    padded = [
        np.pad(each, [(0, 0), *((0, w - n) for w, n in zip(width, each.shape[1:], strict=True))])
        for each in (one, other)
    ]
    return np.concatenate(padded)


def _intermediate(graph: Graph) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrix of edge costs, and for each two nodes those on paths cheaper than their edge, as bits."""
    near = np.full((graph.size, graph.size), NO_EDGE, dtype=np.int64)
    near[np.repeat(np.arange(graph.size), np.diff(graph.offsets)), graph.targets] = graph.costs
    least = all_pairs_costs(near, np.ones(graph.size, dtype=bool))
    bits = np.uint64(1) << np.arange(graph.size, dtype=np.uint64)
    cheaper = least[:, :, None] + least[None, :, :] < near[:, None, :]
    return near, np.where(cheaper, bits[None, :, None], np.uint64(0)).sum(axis=1, dtype=np.uint64)


def active_nodes(view: ProductView) -> np.ndarray:
    """Return (N + R, S) whether a node's label can change an automaton; empty unless the graph is contracted."""
    if not view.macro:
        return np.zeros((0, 0), dtype=bool)
    bits = np.bitwise_or.reduce(view.active, axis=1)
    nodes = np.arange(len(view.classes), dtype=np.uint64)
    return (bits[:, None] >> nodes[None, :]) & np.uint64(1) > 0


@bare_kernel
def decode(view: ProductView, code: Integer, automata: np.ndarray) -> Integer:
    """Write the states of the first automata of a product state, as many as there is room for, and return its node."""
    rest = code // view.nodes
    for i in range(automata.shape[0]):
        automata[i] = rest % view.sizes[i]
        rest //= view.sizes[i]
    return code % view.nodes


@bare_kernel
def masks(view: ProductView, automata: np.ndarray) -> tuple[Integer, Integer]:
    """Return the sets of satisfied tasks, and of satisfied or skipped tasks, as bits."""
    satisfied = done = 0
    for i in range(view.ends.shape[0]):
        if automata[i] == view.ends[i, 0]:
            satisfied |= 1 << i
            done |= 1 << i
        elif automata[i] == view.ends[i, 1]:
            done |= 1 << i
    return satisfied, done
