"""A product as arrays for compiled kernels: the automata's tables, and the graph in one of three forms.

Costs and preference values are whole multiples of units.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from prefplan.models.kernels import NO_EDGE, Integer, inner_kernel
from prefplan.models.manipulation.successors import Moves, Steps

BARRED = -1
"""Stands for the state of a rule's automaton after a label that breaks the rule, if no plan may break it."""


class Automata(NamedTuple):
    """The automata of N tasks, then R rules, over S nodes, of at most Q states and C labels.

    Labels are label classes, or letters where states are generated. P tasks and rules have violation costs.

    Attributes:
        sizes: (N + R,) int64, number of states of each automaton.
        strides: (N + R,) int64: the code of a product state is its node + sum_i strides[i] q_i, and strides[0] the
            number of nodes, or of integers that stand for states.
        ends: (N, 2) int32, the accepting and the skipped state of each, or -1.
        delta: (N + R, Q, C) int32, state after reading a label without relaxation, or `BARRED`.
        tolls: (P, Q, C) units, price of reading a label without relaxation, that is of breaking a rule; empty if no
            step has a violation cost. Prices are int64, or Python's integers where one does not fit.
        relaxed: (X, 2), of each relaxed reading, the state after it, and its price in units.
        first_relaxed: (N + R, Q, C + 1) int32: `relaxed[first_relaxed[i, q, c] : first_relaxed[i, q, c + 1]]` are the
            relaxed readings of label c in state q.
    """

    sizes: np.ndarray
    strides: np.ndarray
    ends: np.ndarray
    delta: np.ndarray
    tolls: np.ndarray
    relaxed: np.ndarray
    first_relaxed: np.ndarray


def changes(automata: Automata) -> np.ndarray:
    """Return (N + R, Q, C) whether reading a label can change an automaton's state."""
    states = np.arange(automata.delta.shape[1])[:, None]
    is_state = states < automata.sizes[:, None, None]
    moves: np.ndarray = is_state & ((automata.delta != states) | (np.diff(automata.first_relaxed, axis=2) > 0))
    return moves


@dataclass(frozen=True)
class Graph:
    """The nodes and edges that are searched, and the states that they stand for.

    Attributes:
        offsets: (S + 1,) int64, first edge of each node, and E.
        targets: (E,) int32, node that each edge leads to.
        costs: (E,) int64, cost of each edge in units, with low bits.
        classes: (S,) int32, label class of each node.
        states: (S,) state of the transition system that each node stands for.
        start: node of s0.
        contracted: whether edges stand for paths through inert states.
        shift: number of low bits of costs, which count actions.
    """

    offsets: np.ndarray
    targets: np.ndarray
    costs: np.ndarray
    classes: np.ndarray
    states: np.ndarray
    start: int
    contracted: bool
    shift: int

    @property
    def size(self) -> int:
        """Number of nodes."""
        return len(self.classes)

    @cached_property
    def near(self) -> np.ndarray:
        """(S, S) int64, the costs of edges as a matrix, NO_EDGE for none."""
        near = np.full((self.size, self.size), NO_EDGE, dtype=np.int64)
        near[np.repeat(np.arange(self.size), np.diff(self.offsets)), self.targets] = self.costs
        return near

    @cached_property
    def least(self) -> np.ndarray:
        """(S, S) int64, least costs from node to node, through any others, NO_EDGE for none (Floyd-Warshall)."""
        least: np.ndarray = self.near
        for via in range(self.size):
            least = np.minimum(least, least[:, via, None] + least[via])
        return least


def bits_of(sets: np.ndarray) -> np.ndarray:
    """Return sets of at most NODE_LIMIT nodes, given as (..., S) bool, as (...,) uint64."""
    bits = np.uint64(1) << np.arange(sets.shape[-1], dtype=np.uint64)
    return np.where(sets, bits, np.uint64(0)).sum(axis=-1, dtype=np.uint64)


class Edges(NamedTuple):
    """A graph of S nodes.

    Attributes:
        offsets: (S + 1,) int64, first edge of each node, and E.
        targets: (E,) int32, node that each edge leads to.
        classes: (S,) int32, label class of each node.
    """

    offsets: np.ndarray
    targets: np.ndarray
    classes: np.ndarray


class Shortcuts(NamedTuple):
    """A contracted graph of S <= 64 nodes, on which every successor changes some automaton (macro-moves).

    Attributes:
        near: (S, S) int64, cost of the edge between two nodes, or NO_EDGE.
        classes: (S,) int32, label class of each node.
        active: (N + R, Q) uint64, as bits, nodes whose label can change automaton i in q.
        distance: (S,) int64, scratch.
    """

    near: np.ndarray
    classes: np.ndarray
    active: np.ndarray
    distance: np.ndarray


class Generated(NamedTuple):
    """A model whose states are generated, as the automata of N tasks and R rules see it.

    Attributes:
        moves: the model, of H poses of the hand and D digits of a state.
        costs: (4 H H,) int64, by price, as in `Steps`; negative where there is no action.
        letters: (N + R, D, r) int64, what each value of a digit adds to the number of the letter that each automaton
            reads.
        steps: scratch, the actions of a state.
    """

    moves: Moves
    costs: np.ndarray
    letters: np.ndarray
    steps: Steps


class Space(NamedTuple):
    """The product that is searched, with its graph in one of three forms; the other two are None.

    Attributes:
        automata: automata of the tasks and the rules.
        edges: a listed graph.
        shortcuts: a contracted graph.
        generated: a model whose states are generated.
    """

    automata: Automata
    edges: Edges | None
    shortcuts: Shortcuts | None
    generated: Generated | None


def space_of(automata: Automata, graph: Graph, generated: Generated | None) -> Space:
    """Return a product over a graph, or over generated states, as arrays."""
    if graph.contracted:
        active = bits_of(changes(automata)[:, :, graph.classes])
        shortcuts = Shortcuts(graph.near, graph.classes, active, np.empty(graph.size, np.int64))
        return Space(automata._replace(strides=strides_of(graph.size, automata.sizes)), None, shortcuts, None)
    edges = Edges(graph.offsets, graph.targets, graph.classes) if generated is None else None
    return Space(automata, edges, None, generated)


def strides_of(nodes: int, sizes: np.ndarray) -> np.ndarray:
    """Return the strides of automata of some sizes over a number of nodes; see `Automata`."""
    return np.cumprod([nodes, *sizes])[:-1].astype(np.int64)


@inner_kernel
def decode(automata: Automata, code: Integer, states: np.ndarray) -> Integer:
    """Write the states of the automata of a product state, and return its node."""
    rest = code // automata.strides[0]
    for i in range(states.shape[0]):
        states[i] = rest % automata.sizes[i]
        rest //= automata.sizes[i]
    return code % automata.strides[0]
