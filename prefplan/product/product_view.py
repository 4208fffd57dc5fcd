"""A product as arrays for compiled kernels, grouped in named tuples.

Costs and preference values are whole multiples of `Product.units`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.product.contraction import Graph, all_pairs_costs
from prefplan.product.kernels import NO_EDGE, Integer, bare_kernel
from prefplan.product.moves import Moves
from prefplan.product.product_automaton import Product


class ProductView(NamedTuple):
    """A product (Definition 7) over a graph of S nodes, N tasks, Q automaton states at most and C label classes.

    Attributes:
        offsets: (S + 1,) int64, targets: (E,) int32, costs: (E,) int64: edges by source node.
        classes: (S,) int32, label class of each node.
        sizes: (N,) int64, automaton states, strides: (N,) int64: code = node + sum_i strides[i] * q_i.
        jump: (N, Q, C) int64, strides[i] times the state after the free reading of a class.
        extra_first: (N, Q, C + 1) int32, extra_jump: (X,) int64, extra_price: (X,) int64: the bought readings.
        active: (N, Q) uint64, as bits, nodes whose label can change the state of automaton i in q; 0 unless `macro`.
        near: (S, S) int64, cost of the edge between two nodes, or NO_EDGE, and through: (S, S) uint64, as bits, the
            nodes that lie on cheaper paths between them; empty unless `macro`.
        ends: (N, 2) int32, the accepting and the skipped state of each automaton, or -1.
        shift: number of low bits of costs, which count actions.
        moves: the model, where its states are generated; there are no edges and classes then.
        nodes: number of nodes, or of integers that stand for states.
        relaxed: whether there are bought readings.
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
    extra_first: np.ndarray
    extra_jump: np.ndarray
    extra_price: np.ndarray
    active: np.ndarray
    near: np.ndarray
    through: np.ndarray
    ends: np.ndarray
    moves: Moves
    nodes: int
    shift: int
    relaxed: bool
    generated: bool
    macro: bool


def view(product: Product, graph: Graph) -> ProductView:
    """Return a product over a graph as arrays."""
    nodes = graph.size if graph.contracted else product.nodes
    strides = np.cumprod(np.concatenate([[nodes], product.sizes[:-1]])).astype(np.int64)
    tasks, most, _ = product.delta.shape
    active = np.zeros((tasks, most), dtype=np.uint64)
    if graph.contracted:
        for i, q in np.ndindex(tasks, most):
            changes = (product.delta[i, q] != q) | (np.diff(product.extra_first[i, q]) > 0)
            for v in np.flatnonzero(changes[graph.classes]):
                active[i, q] |= np.uint64(1) << np.uint64(v)
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
        sizes=product.sizes,
        strides=strides,
        jump=product.delta * strides[:, None, None],
        extra_first=product.extra_first,
        extra_jump=product.extra_state * strides[owner],
        extra_price=product.extra_price,
        active=active,
        near=near,
        through=through,
        ends=product.ends,
        moves=product.moves,
        nodes=nodes,
        shift=product.shift,
        relaxed=product.relaxed,
        generated=len(product.moves.radices) > 0,
        macro=graph.contracted,
    )


def _intermediate(graph: Graph) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrix of edge costs, and for each two nodes those on paths cheaper than their edge, as bits."""
    near = np.full((graph.size, graph.size), NO_EDGE, dtype=np.int64)
    near[np.repeat(np.arange(graph.size), np.diff(graph.offsets)), graph.targets] = graph.costs
    least = all_pairs_costs(near, np.ones(graph.size, dtype=bool))
    bits = np.uint64(1) << np.arange(graph.size, dtype=np.uint64)
    cheaper = least[:, :, None] + least[None, :, :] < near[:, None, :]
    return near, np.where(cheaper, bits[None, :, None], np.uint64(0)).sum(axis=1, dtype=np.uint64)


def active_nodes(view: ProductView) -> np.ndarray:
    """Return (N, S) whether a node's label can change an automaton; empty unless the graph is contracted."""
    if not view.macro:
        return np.zeros((0, 0), dtype=bool)
    bits = np.bitwise_or.reduce(view.active, axis=1)
    nodes = np.arange(len(view.classes), dtype=np.uint64)
    return (bits[:, None] >> nodes[None, :]) & np.uint64(1) > 0


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
    """Return the sets of satisfied tasks, and of satisfied or skipped tasks, as bits."""
    satisfied = done = 0
    for i in range(automata.shape[0]):
        if automata[i] == view.ends[i, 0]:
            satisfied |= 1 << i
            done |= 1 << i
        elif automata[i] == view.ends[i, 1]:
            done |= 1 << i
    return satisfied, done
