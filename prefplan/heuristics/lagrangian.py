"""Lower bounds of the cost of plans whose preference value stays below a limit, by Lagrangian relaxation.

The cheapest plans are seldom the preferred ones, which separate bounds of cost and of mu do not reflect. For weights a
and b let h be the least sum of a times the cost and b times the growth of mu until all tasks are satisfied. If mu may
grow by no more than B until then, the cost-to-go is at least (h - b B) / a: the bound of a constrained shortest path
(G. Y. Handler and I. Zang, "A dual algorithm for the constrained shortest path problem", Networks 1980), which prunes
its enumeration (W. M. Carlyle, J. O. Royset and R. K. Wood, "Lagrangian relaxation and enumeration for solving
constrained shortest-path problems", Networks 2008). On a front, mu must end below that of the last plan found.

One pair of weights serves a whole front: a unit of cost weighs about as much as the growth of mu that comes with it, so
that plans all along the front have nearly the same sum.

h is tabulated for all tasks together, as `sweep` does for a few: only for automata that are acyclic up to
self-loops, and over least costs between nodes that ignore the labels passed, which is a relaxation. Entries are kept
only for automaton states that reading a node's label leads to, since a search reaches a node by reading its label.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.sweep import Stages
from prefplan.limits import check_limits, run_within_limits
from prefplan.models.kernels import INFINITE, Integer, bare_kernel, kernel
from prefplan.product.contraction import NODE_LIMIT, bits_of

LARGEST = 30_000
"""Largest entry of a table, in its units: twice as much fits 16 bits."""

SHARE = Fraction(1, 2)
"""Weight of a unit of cost, in terms of the mean growth of mu that comes with it."""

LARGEST_WEIGHT = 8
"""The smaller weight and the ratio of both are whole or fractions of numbers up to this, so that sums stay small."""


class Weights(NamedTuple):
    """The weights of a unit of cost and of a unit of mu, both positive, and the unit of the sums in a table."""

    cost: int
    mu: int
    unit: int


class Lagrangian(NamedTuple):
    """A table over S nodes and N tasks of at most Q automaton states.

    Attributes:
        weights: of cost and mu.
        first: (S,) int64, place: (S, N, Q) int64: entry = first[node] + sum_i place[node, i, q_i]; there is none where
            a place is -1.
        table: (E,) uint16, sums in units, cut off at LARGEST.
    """

    weights: Weights
    first: np.ndarray
    place: np.ndarray
    table: np.ndarray


def entries_of(stages: Stages) -> int:
    """Return how many entries a table has."""
    return sum(math.prod(map(len, node)) for node in _entered(stages) if node)


def _layout(stages: Stages) -> tuple[np.ndarray, np.ndarray, int]:
    """Return `first` and `place` as in `Lagrangian`, and the number of entries."""
    nodes, (tasks, most, _) = len(stages.classes), stages.delta.shape
    first, place = np.zeros(nodes, dtype=np.int64), np.full((nodes, tasks, most), -1, dtype=np.int64)
    entries = 0
    for v, kept in enumerate(_entered(stages)):
        first[v], stride = entries, 1
        for i, states in enumerate(kept):
            place[v, i, states] = stride * np.arange(len(states))
            stride *= len(states)
        entries += stride if kept else 0
    return first, place, entries


def _entered(stages: Stages) -> list[list[np.ndarray]]:
    """Return for each node the states of each automaton that reading its label leads to, none if it changes nothing.

    Where it can change one automaton only, a search goes there only to change that one.
    """
    found: list[list[np.ndarray]] = []
    for v, label in enumerate(stages.classes):
        changing = np.flatnonzero(stages.active[:, v])
        kept = []
        for i, size in enumerate(stages.sizes) if len(changing) else ():
            before = np.arange(size)
            if changing.tolist() == [i]:
                before = before[stages.delta[i, before, label] != before]
            kept.append(np.unique(stages.delta[i, before, label]))
        found.append(kept)
    return found


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


def lagrangian_table(stages: Stages, rates: np.ndarray, shift: int, weights: Weights) -> Lagrangian:
    """Return the table for a pair of weights.

    Args:
        stages: the product.
        rates: as for `weights_for`.
        shift: number of low bits of costs to leave out.
        weights: of cost and of mu.

    Raises:
        LimitError: a limit was reached.
    """
    first, places, entries = _layout(stages)
    check_limits(2 * entries)
    table = np.empty(entries, dtype=np.uint16)
    nodes = len(stages.classes)
    different, kind = np.unique(rates, return_inverse=True)
    least = stages.least >> shift
    steps = np.full((len(different), nodes, NODE_LIMIT), LARGEST, dtype=np.uint16)
    for r, rate in enumerate(different.tolist()):
        factor = weights.cost + weights.mu * rate
        most = LARGEST * weights.unit // factor
        steps[r, :, :nodes] = np.minimum(np.minimum(least, most) * factor // weights.unit, LARGEST).T
        steps[r, :, :nodes][least.T > most] = LARGEST
    after = stages.delta[:, :, stages.classes]
    place = places.transpose(1, 2, 0)
    sweep = LagrangianSweep(
        order=stages.order,
        sizes=stages.sizes,
        ends=stages.ends,
        active=bits_of(after != np.arange(after.shape[1])[None, :, None]),
        kept=bits_of(place >= 0),
        first=first,
        here=place.copy(),
        onward=np.take_along_axis(place, after.astype(np.int64), axis=1),
        steps=steps,
        kind=kind.reshape(-1).astype(np.int64),
    )
    run_within_limits(lambda stop: fill(sweep, table, stop))
    return Lagrangian(weights, first, places, table)


class LagrangianSweep(NamedTuple):
    """Input for filling a table of S nodes, N tasks of at most Q automaton states and R rates.

    Attributes:
        order: (N, Q) int64, sizes: (N,) int64, ends: (N, 2) int32: see `Stages`.
        active: (N, Q) uint64, nodes whose label changes a state. kept: (N, Q) uint64, nodes that have entries for it.
        first: (S,) int64. here: (N, Q, S) int64, what the state adds to the index of a node's entry. onward: (N, Q, S)
            int64, the same after reading the node's label.
        steps: (R, S, NODE_LIMIT) uint16, weighted cost to a node from all others.
        kind: (2^N,) int64, number of the rate for each set of satisfied tasks.
    """

    order: np.ndarray
    sizes: np.ndarray
    ends: np.ndarray
    active: np.ndarray
    kept: np.ndarray
    first: np.ndarray
    here: np.ndarray
    onward: np.ndarray
    steps: np.ndarray
    kind: np.ndarray


@kernel
def fill(sweep: LagrangianSweep, table: np.ndarray, stop: np.ndarray) -> None:
    """Fill a table, each combination of automaton states after all its successors; return early once `stop` is set.

    Partial sums over the last tasks are kept, as the first task's state changes most often.
    """
    tasks, nodes = sweep.sizes.shape[0], sweep.first.shape[0]
    here, onward = np.zeros((tasks + 1, nodes), dtype=np.int64), np.zeros((tasks + 1, nodes), dtype=np.int64)
    for v in range(nodes):
        here[tasks, v] = onward[tasks, v] = sweep.first[v]
    stops, kept = np.zeros(tasks + 1, dtype=np.uint64), np.zeros(tasks + 1, dtype=np.uint64)
    satisfied, finished = np.zeros(tasks + 1, dtype=np.int64), np.ones(tasks + 1, dtype=np.bool_)
    ranks, costs = np.zeros(tasks, dtype=np.int64), np.zeros(NODE_LIMIT, dtype=np.uint16)
    kept[tasks] = ~np.uint64(0)
    changed = tasks
    while not stop[0]:
        for i in range(changed - 1, -1, -1):
            q = sweep.order[i, ranks[i]]
            if i > 0:
                for v in range(nodes):
                    here[i, v] = here[i + 1, v] + sweep.here[i, q, v]
                    onward[i, v] = onward[i + 1, v] + sweep.onward[i, q, v]
            stops[i], kept[i] = stops[i + 1] | sweep.active[i, q], kept[i + 1] & sweep.kept[i, q]
            satisfied[i] = satisfied[i + 1] | ((q == sweep.ends[i, 0]) << i)
            finished[i] = finished[i + 1] and (q == sweep.ends[i, 0] or q == sweep.ends[i, 1])
        q = sweep.order[0, ranks[0]]
        if finished[0]:
            costs[:] = 0
        else:
            steps = sweep.steps[sweep.kind[satisfied[0]]]
            _least_sums(steps, stops[0], onward[1], sweep.onward[0, q], table, costs)
        for v in range(nodes):
            if kept[0] >> np.uint64(v) & np.uint64(1):
                table[here[1, v] + sweep.here[0, q, v]] = costs[v]
        changed = 1
        while ranks[changed - 1] + 1 == sweep.sizes[changed - 1]:
            ranks[changed - 1] = 0
            changed += 1
            if changed > tasks:
                return
        ranks[changed - 1] += 1


@bare_kernel
def _least_sums(
    steps: np.ndarray,
    stops: Integer,
    others: np.ndarray,
    first: np.ndarray,
    table: np.ndarray,
    costs: np.ndarray,
) -> None:
    """Write the least sum from every node, through those whose label changes some automaton.

    After reading it, the index of node v's entry is others[v] + first[v].
    """
    for u in range(NODE_LIMIT):
        costs[u] = np.uint16(LARGEST)
    for v in range(first.shape[0]):
        if stops >> np.uint64(v) & np.uint64(1):
            rest, step = table[others[v] + first[v]], steps[v]
            # A loop of fixed length is vectorised: it becomes four instructions.
            for u in range(NODE_LIMIT):
                cost = np.uint16(step[u] + rest)
                costs[u] = cost if cost < costs[u] else costs[u]


@bare_kernel
def lagrangian_bound(known: Lagrangian | None, node: Integer, automata: np.ndarray, growth: Integer) -> Integer:
    """Return a lower bound of the cost-to-go, without low bits, of plans along which mu grows by at most `growth`."""
    if known is None:
        return np.int64(0)
    entry = known.first[node]
    for i in range(known.place.shape[1]):
        place = known.place[node, i, automata[i]]
        if place < 0:
            return np.int64(0)
        entry += place
    weights = known.weights
    total = np.int64(known.table[entry]) * weights.unit
    if growth >= total // weights.mu:
        return np.int64(0)
    return (total - weights.mu * growth + weights.cost - 1) // weights.cost
