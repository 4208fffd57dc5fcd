"""A product as arrays for compiled kernels: the automata's tables, and the graph in one of three forms.

Costs and preference values are whole multiples of `Problem.units`.
"""

from typing import NamedTuple

import numpy as np

from prefplan.models.kernels import Integer, inner_kernel
from prefplan.models.manipulation.successors import Moves, Steps
from prefplan.product.contraction import Graph, bits_of, changes
from prefplan.product.product_automaton import Product


class Automata(NamedTuple):
    """The automata of N tasks, then R rules, over S nodes, of at most Q states and C labels.

    Labels are told apart by class, or by letter where states are generated.

    P tasks and rules have violation costs.

    Attributes:
        sizes: (N + R,) int64, states of each.
        strides: (N + R,) int64: the code of a product state is its node + sum_i strides[i] q_i, and strides[0] the
            number of nodes, or of integers that stand for states.
        ends: (N, 2) int32, the accepting and the skipped state of each, or -1.
        jump: (N + R, Q, C) int64, what the state after the free reading of a label adds to the code; negative if the
            label is barred.
        tolls: (P, Q, C) int64, the price of the free reading of a label; empty if no step has a violation cost.
        relaxed: (X, 2) int64, of each relaxed reading, what the state after it adds to the code, and its price.
        first_relaxed: (N + R, Q, C + 1) int32: `relaxed[first_relaxed[i, q, c] : first_relaxed[i, q, c + 1]]` are
            those of a label.
    """

    sizes: np.ndarray
    strides: np.ndarray
    ends: np.ndarray
    jump: np.ndarray
    tolls: np.ndarray
    relaxed: np.ndarray
    first_relaxed: np.ndarray


class Edges(NamedTuple):
    """A graph of S nodes.

    Attributes:
        offsets: (S + 1,) int64, targets: (E,) int32: edges by source node.
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
        costs: (4 H H,) int64, by price, as in `Steps`; negative where an action was not measured.
        letters: (N + R, D, r) int64, what each value of a digit adds to the number of the letter that each automaton
            reads.
        steps: scratch, the actions of a state.
        unmeasured: (1,) int64, output: a state with an action whose cost was not measured, -1 if none was met.
    """

    moves: Moves
    costs: np.ndarray
    letters: np.ndarray
    steps: Steps
    unmeasured: np.ndarray


class Space(NamedTuple):
    """What a search is over; of the forms of its graph, one is there and the others are None.

    Attributes:
        automata: the tasks' and the rules'.
        edges: a listed graph.
        shortcuts: a contracted graph.
        generated: a model whose states are generated.
    """

    automata: Automata
    edges: Edges | None
    shortcuts: Shortcuts | None
    generated: Generated | None


def space_of(product: Product, graph: Graph) -> Space:
    """Return a product over a graph as arrays."""
    edges = shortcuts = None
    if graph.contracted:
        active = bits_of(changes(product)[:, :, graph.classes])
        shortcuts = Shortcuts(graph.near, graph.classes, active, np.empty(graph.size, np.int64))
    elif product.generated is None:
        edges = Edges(graph.offsets, graph.targets, graph.classes)
    nodes = graph.size if graph.contracted else product.nodes
    sizes = product.follower_sizes
    strides = np.cumprod([nodes, *sizes])[:-1].astype(np.int64)
    counts = np.diff(product.extra_first, axis=2).sum(axis=(1, 2))
    owner = np.repeat(np.arange(len(counts)), counts)
    automata = Automata(
        sizes=sizes,
        strides=strides,
        ends=product.ends,
        jump=product.delta * strides[:, None, None],
        tolls=product.tolls,
        relaxed=np.stack([product.extra_state * strides[owner], product.extra_price], axis=1),
        first_relaxed=product.extra_first,
    )
    return Space(automata, edges, shortcuts, product.generated)


@inner_kernel
def decode(automata: Automata, code: Integer, states: np.ndarray) -> Integer:
    """Write the states of the automata of a product state, and return its node."""
    rest = code // automata.strides[0]
    for i in range(states.shape[0]):
        states[i] = rest % automata.sizes[i]
        rest //= automata.sizes[i]
    return code % automata.strides[0]
