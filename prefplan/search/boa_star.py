"""BOA* for (total cost, mu), compiled.

C. Hernandez Ulloa et al., "A Simple and Fast Bi-Objective Search Algorithm", ICAPS 2020, for measures for which (g, mu)
is a sufficient key (`Measure.bi_objective`). With a bound on mu it is Algorithm 1; comparing labels by cost only, A*.

A new label is compared with all undominated labels of its product state, expanded or not. Heuristic tables are looked
up only until the bound puts the label behind those expanded now, and the others when the label is popped: most states
are never expanded.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from prefplan.heuristics.lagrangian import lagrangian_bound
from prefplan.heuristics.pattern_database import COST_BOUND, LIKELY, LOOKED, cost_bound, raise_bound
from prefplan.heuristics.preference_bound import growth_bound
from prefplan.heuristics.prepare import Bounds, Prepared
from prefplan.heuristics.projection import observe
from prefplan.models.kernels import INFINITE, UNBOUNDED, Integer, bare_kernel
from prefplan.product.space import Space, decode
from prefplan.search.driver import Search, in_units
from prefplan.search.growth import Growth, growth_of, mu_after
from prefplan.search.labels import (
    AT,
    COL,
    DOMINATED,
    END,
    GOAL_BIT,
    NONE,
    Labels,
    Memory,
    describe,
    expand,
    is_dominated,
    next_successor,
    pop,
    push,
    slot_of,
    undominated,
)


@bare_kernel
def run(space: Space, growth: Growth, bounds: Bounds, memory: Memory, cost_only: bool, pops: Integer) -> Integer:
    """Expand labels until a goal is found, memory runs out or enough were popped; return which (`END`).

    Args:
        space: what is searched.
        growth: how mu grows.
        bounds: heuristics.
        memory: of the search. `limits`: mu must stay below the first, and cost must not exceed the second;
            `begin`: (K, 1), mu of each start's label.
        cost_only: whether labels are compared by cost alone (A*).
        pops: most labels to pop from the open list.
    """
    states, labels, counters, limits = memory.states, memory.labels, memory.counters, memory.limits
    while True:
        while counters[AT.NEXT] < counters[AT.COUNT]:
            end = _enter(space, growth, bounds, memory, cost_only)
            if end != END.ENTERED:
                return end
            counters[AT.NEXT] += 1
        if counters[AT.OPEN] == 0:
            return END.EXHAUSTED
        if pops == 0:
            return END.PAUSED
        pops -= 1
        label = pop(memory.queue, counters)
        known = states.known[labels.row[label]]
        estimate = _estimate(space, bounds, memory, known, label)
        if estimate > counters[AT.LOWEST]:
            if estimate <= limits[1]:
                push(memory.queue, counters, label, estimate)
            continue
        if known[COL.SATISFIED] < 0:
            limits[0], counters[AT.FOUND] = labels.mu[label], label
            return END.GOAL
        expand(space, memory.buffer, counters, label, known[COL.CODE])


@bare_kernel
def _estimate(space: Space, bounds: Bounds, memory: Memory, known: np.ndarray, label: Integer) -> Integer:
    """Return a lower bound of what a popped label costs at the end, UNBOUNDED if it is pruned.

    The bound of its product state is raised until it exceeds the estimate of the label, or nothing is left to raise it.
    """
    cost, mu, automata = memory.labels.cost[label], memory.labels.mu[label], memory.buffer.automata
    if mu == DOMINATED or mu + known[COL.GROWTH_BOUND] >= memory.limits[0]:
        return np.int64(UNBOUNDED)
    node = decode(space.automata.nodes, space.automata.sizes, known[COL.CODE], automata)
    raise_bound(bounds.patterns, bounds.landmarks, node, automata, known, memory.counters[AT.LOWEST] - cost)
    within = lagrangian_bound(bounds.lagrangian, node, automata, memory.limits[0] - 1 - mu)
    rest = max(known[COST_BOUND], within << space.shift)
    return cost + rest if rest < INFINITE else np.int64(UNBOUNDED)


@bare_kernel
def _enter(space: Space, growth: Growth, bounds: Bounds, memory: Memory, cost_only: bool) -> Integer:
    """Make a label of the next successor unless it is pruned; return ENTERED, or why that is not possible (`END`)."""
    states, labels, counters = memory.states, memory.labels, memory.counters
    limits, buffer = memory.limits, memory.buffer
    parent, shift = counters[AT.PARENT], space.shift
    cost = mu = satisfied = likely = np.int64(0)
    if parent != NONE:
        cost, mu = labels.cost[parent], labels.mu[parent]
        satisfied, likely = states.known[labels.row[parent], COL.SATISFIED], states.known[labels.row[parent], LIKELY]
    k = next_successor(counters)
    after = cost + buffer.cost[k]
    before, spent = cost >> shift, after >> shift
    if after > limits[1]:
        return END.ENTERED
    if spent >= growth.cost_limit:
        return END.TOO_LARGE
    if parent == NONE:
        mu = memory.begin[k, 0]
    else:
        mu = np.int64(mu_after(growth, mu, satisfied, before, spent, buffer.violation[k], space.automata.pays))
    if mu >= limits[0]:
        return END.ENTERED
    slack, most = limits[0] - mu, min(limits[1] - after, INFINITE - 1)
    slot = slot_of(states, buffer.code[k])
    row = np.int64(states.slots[slot])
    if row == NONE:
        row = counters[AT.ROWS]
        if row == states.known.shape[0]:
            return END.MORE_ROWS
        states.known[row, LIKELY] = likely
        lookups = min(most, counters[AT.LOWEST] - after)
        _bound_state(space, bounds, buffer.code[k], slack, lookups, states.known[row], buffer.automata)
    known = states.known[row]
    if known[COL.GROWTH_BOUND] >= slack or known[COST_BOUND] > most:
        return END.ENTERED
    if states.slots[slot] == NONE:
        states.slots[slot] = row
        counters[AT.ROWS] += 1
    if is_dominated(labels, known[COL.HEAD], after, mu, cost_only):
        return END.ENTERED
    estimate = max(after + known[COST_BOUND], counters[AT.LOWEST])
    if estimate >= INFINITE or mu >= INFINITE:
        return END.TOO_LARGE
    label = counters[AT.LABELS]
    if label == labels.row.shape[0]:
        return END.MORE_LABELS
    push(memory.queue, counters, label, estimate)
    labels.row[label], labels.cost[label], labels.mu[label], labels.parent[label] = row, after, mu, parent
    labels.sibling[label], known[COL.HEAD] = undominated(labels, known[COL.HEAD], after, mu), label
    counters[AT.LABELS] += 1
    return END.ENTERED


@bare_kernel
def _bound_state(
    space: Space,
    bounds: Bounds,
    code: Integer,
    growth_limit: Integer,
    cost_limit: Integer,
    known: np.ndarray,
    automata: np.ndarray,
) -> None:
    """Fill the row of a new product state.

    Args:
        space: what is searched.
        bounds: heuristics.
        code: the product state.
        growth_limit: stop if the growth of mu to the end is this much or more.
        cost_limit: stop looking up tables once the bound of the cost-to-go exceeds this.
        known: the row; LIKELY is the table to look up first.
        automata: (N + R,) scratch.
    """
    node = decode(space.automata.nodes, space.automata.sizes, code, automata)
    describe(space.automata.ends, code, automata, known)
    observe(bounds.projections, node)
    patterns, satisfied = bounds.patterns, known[COL.SATISFIED] & ~GOAL_BIT
    growth = growth_bound(bounds.blocks, bounds.projections, node, automata, satisfied, 0)
    known[COL.GROWTH_BOUND], known[COST_BOUND], known[LOOKED] = growth, 0, 0
    if growth >= growth_limit:
        return
    if patterns.add_up:
        known[COST_BOUND] = cost_bound(patterns, bounds.projections, node, automata, 0)
        known[LOOKED] = patterns.base.shape[0]
    raise_bound(patterns, bounds.landmarks, node, automata, known, cost_limit)


class BiObjectiveSearch(Search):
    """BOA*, for measures whose label key is (g, mu).

    Attributes:
        max_cost: inclusive bound of the total cost, in units.
    """

    def __init__(
        self,
        prepared: Prepared,
        *,
        max_mu: Fraction | None = None,
        max_cost: float = math.inf,
        cost_only: bool = False,
        single: bool = False,
    ) -> None:
        """Make the search ready.

        Args:
            prepared: what to search.
            max_mu: inclusive bound of mu, in the user's units.
            max_cost: inclusive bound of the total cost, in units.
            cost_only: find one cheapest goal, whatever its mu (A*).
            single: find the first goal of the front only.
        """
        self.max_cost = max_cost
        self._max_mu = UNBOUNDED if max_mu is None else math.floor(in_units(prepared.product, max_mu))
        self._cost_only, self.single = cost_only, single
        self._growth = growth_of(prepared.product)
        super().__init__(prepared, max_cost)

    def reset(self) -> None:
        """Forget everything but the bounds."""
        self.limits[0] = min(self._max_mu + 1, UNBOUNDED)
        super().reset()

    def _new_labels(self, count: int) -> Labels:
        kinds = (np.int32, np.int64, np.int64, np.int32, np.int32)
        return Labels(*(np.empty(count, kind) for kind in kinds))

    def _run(self, pops: int) -> int:
        wait = self.prepared.bounds_wait(cost_only=self._cost_only) - self.counters[AT.EXPANDED]
        if wait <= 0:
            self.prepared.raise_bounds(cost_only=self._cost_only)
            if self._cost_only:
                self.reset()
        elif wait < pops:
            pops = math.ceil(wait)
        prepared = self.prepared
        return int(run(prepared.space, self._growth, prepared.bounds, self.memory, self._cost_only, pops))

    def _objectives(self, label: int) -> tuple[Fraction, Fraction]:
        units, constant = self.product.units, self.product.problem.measure.constant
        return self._cost(label) * units.cost, int(self.labels.mu[label]) * units.mu + constant

    def adopt_states(self, other: Search) -> None:
        """Take over the product states, with their bounds, of another search of the same product."""
        self.states, self.counters[AT.ROWS] = other.states, other.counters[AT.ROWS]
        self.states.known[: other.counters[AT.ROWS], COL.HEAD] = NONE

    def _accept(self, label: int, objectives: tuple[Any, ...]) -> bool:
        if self._cost_only:
            self.counters[[AT.OPEN, AT.NEXT, AT.COUNT]] = 0
        elif self.single:
            self.limits[1] = self._up_to(self._cost(label))
        return True
