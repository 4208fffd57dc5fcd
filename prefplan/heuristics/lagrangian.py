"""Lower bounds of the cost of plans whose preference value stays below a limit, by Lagrangian relaxation.

Cheap plans are seldom preferred plans; separate bounds of cost and of mu cannot show this. For weights a and b, let h
be the least value of a * cost + b * (growth of mu) until all tasks are satisfied. If mu may grow by at most B, the
cost-to-go is at least (h - b B) / a. This is the Lagrangian bound of the constrained shortest path problem (G. Y.
Handler and I. Zang, "A dual algorithm for the constrained shortest path problem", Networks 1980), which also prunes an
enumeration of paths (W. M. Carlyle, J. O. Royset and R. K. Wood, "Lagrangian relaxation and enumeration for solving
constrained shortest-path problems", Networks 2008). In a search for a front, mu must end below the mu of the last plan.

One pair of weights serves a whole front: a unit of cost weighs `SHARE` of the mean growth of mu that comes with it, so
that plans all along the front have nearly the same sum.

`sweep` fills the table of h for all tasks together: all automata must be acyclic up to self-loops, and the labels that
a path passes between two nodes are ignored, which is a relaxation. The table has entries only for automaton states that
reading a node's label leads to, since a search reaches a node by reading its label.
"""

import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.sweep import ABSENT, MOST, Layout, Stages, sweep
from prefplan.limits import check_limits, run_within_limits
from prefplan.models.kernels import INFINITE, Integer, inner_kernel
from prefplan.product.space import changes

LARGEST = MOST[np.dtype(np.uint16)]
"""Entry that stands for no path; all sums in a table, in its units, are less."""

SHARE = Fraction(1, 2)
"""Weight of a unit of cost, in terms of the mean growth of mu that comes with it."""

LARGEST_WEIGHT = 8
"""Upper bound of the smaller of the two weights: their ratio is rounded accordingly, so that sums stay small."""


class Weights(NamedTuple):
    """The weights of a unit of cost and of a unit of mu, both positive, and the unit of the sums in a table."""

    cost: int
    mu: int
    unit: int


class Lagrangian(NamedTuple):
    """A table for all tasks together.

    Attributes:
        weights: of cost and mu.
        layout: of the table.
        table: (E,) uint16, sums in units, less than LARGEST.
    """

    weights: Weights
    layout: Layout
    table: np.ndarray


NO_ENTRIES = Lagrangian(Weights(1, 1, 1), Layout(np.zeros((0, 0, 0), np.int64), 0), np.zeros(0, np.uint16))
"""A table before it is filled. It has the type of others, so that the search is compiled once for both."""


def sparse_layout(stages: Stages) -> Layout:
    """Return the layout of a table for all tasks, with entries only for states that reading a node's label leads to.

    A search reaches a node by reading its label. If the label can change one automaton only, the search goes there only
    to change this automaton.
    """
    after, active = stages.after, np.logical_or.reduce(changes(stages.product.tables), axis=1)[:, stages.graph.classes]
    tasks, most, nodes = after.shape
    reached = np.zeros((nodes, tasks, most), dtype=bool)
    alone = active & (active.sum(axis=0) == 1)
    for i, size in enumerate(stages.product.sizes.tolist()):
        q, v = np.nonzero((after[i, :size] != np.arange(size)[:, None]) | ~alone[i])
        reached[v, i, after[i, q, v]] = True
    reached[~active.any(axis=0)] = False
    strides = np.cumprod(np.insert(reached.sum(axis=2), 0, 1, axis=1), axis=1)
    place = np.where(reached, strides[:, :-1, None] * (np.cumsum(reached, axis=2) - 1), ABSENT)
    ends = np.cumsum(strides[:, -1])
    place[:, 0] += (ends - strides[:, -1])[:, None]
    return Layout(place, int(ends[-1]))


def weights_for(rates: np.ndarray, cost: int) -> Weights | None:
    """Return weights that give the plans of a front about the same sum; None if mu does not grow with the cost.

    Args:
        rates: (2^N,) int64, how much mu grows for each unit of cost while a set of tasks is satisfied.
        cost: about what a plan costs, in units.
    """
    mean = Fraction(int(rates.sum()), len(rates))
    if not mean:
        return None
    ratio = SHARE * mean
    close = ratio.limit_denominator(LARGEST_WEIGHT) if ratio >= 1 else 1 / (1 / ratio).limit_denominator(LARGEST_WEIGHT)
    total = math.ceil((close.numerator + close.denominator * mean) * cost)
    return Weights(close.numerator, close.denominator, total // LARGEST + 1) if total < INFINITE else None


def lagrangian_table(stages: Stages, layout: Layout, rates: np.ndarray, weights: Weights) -> Lagrangian:
    """Return the table for a pair of weights, without low bits of costs; `rates` as for `weights_for`."""
    factors = weights.cost + weights.mu * rates
    check_limits(2 * layout.entries)
    table = np.empty(layout.entries, dtype=np.uint16)
    tasks, shift = range(len(stages.order)), stages.graph.shift
    run_within_limits(sweep(stages, tasks, factors, table, layout=layout, shift=shift, unit=weights.unit))
    return Lagrangian(weights, layout, table)


@inner_kernel
def lagrangian_bound(lagrangian: Lagrangian | None, node: Integer, automata: np.ndarray, growth: Integer) -> Integer:
    """Return a lower bound of the cost-to-go, without low bits, of plans along which mu grows by at most `growth`."""
    if lagrangian is None:
        return np.int64(0)
    entry = np.int64(0)
    for i in range(lagrangian.layout.place.shape[1]):
        entry += lagrangian.layout.place[node, i, automata[i]]
    if not 0 <= entry < lagrangian.layout.entries:
        return np.int64(0)
    weights = lagrangian.weights
    total = np.int64(lagrangian.table[entry]) * weights.unit
    if growth >= total // weights.mu:
        return np.int64(0)
    return (total - weights.mu * growth + weights.cost - 1) // weights.cost
