"""The paths to the goals of a search as arrays, the plans on them, and their values, derived from the model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from typing import Any

import numpy as np

from prefplan.ledger import Ledger
from prefplan.limits import check_limits
from prefplan.logic.weighted_dfa import Follower
from prefplan.plan import Plan
from prefplan.product.contraction import Graph
from prefplan.product.product_automaton import Product
from prefplan.product.starts import Start
from prefplan.search.plan_extraction import edges_between, plan_of

NO_STEP = "the search made a step that the model does not have"


@dataclass(frozen=True)
class Paths:
    """Paths through a product whose states are listed: a tree of T steps, in which paths that begin alike are one.

    Attributes:
        product: what was searched.
        before: (T,) int64, the step before each one; a start is before itself. Each step comes after the one before it.
        edges: (T,) int64, the system's edge of each step; of no meaning for a start.
        automata: (T, N + R) int64, states of the automata after each step.
        starts: by number of the step, how paths begin.
        ends: (n,) int64, the last step of each path.
    """

    product: Product
    before: np.ndarray
    edges: np.ndarray
    automata: np.ndarray
    starts: Mapping[int, Start]
    ends: np.ndarray

    @classmethod
    def through(
        cls,
        product: Product,
        graph: Graph,
        nodes: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray],
        starts: Mapping[int, Start],
        ends: np.ndarray,
    ) -> Paths:
        """Return the paths that pass some nodes of a graph; see `edges_between`.

        Args:
            product: what was searched.
            graph: the graph that it was searched over.
            nodes: (U,) each: the number before, the node, the cost up to it as in `Product.costs`, and (U, N + R) the
                states of the automata.
            starts: by number.
            ends: (n,) numbers.
        """
        before, edges, automata, last = list[int](), list[int](), list[int](), list[int]()
        numbers, places, costs, states = (column.tolist() for column in nodes)
        for k, (at, node, cost) in enumerate(zip(numbers, places, costs, strict=True)):
            passed = [-1]
            if at != k:
                rest = tuple(states[at])
                passed = edges_between(product, graph, places[at], node, rest, cost - costs[at])
            first = len(edges)
            before += [first if at == k else last[at], *range(first, first + len(passed) - 1)]
            edges += passed
            automata += [*[at] * (len(passed) - 1), k]
            last.append(len(edges) - 1)
        return cls(
            product,
            np.array(before, dtype=np.int64),
            np.array(edges, dtype=np.int64),
            nodes[3][np.array(automata, dtype=np.int64)],
            {last[k]: start for k, start in starts.items()},
            np.array([last[end] for end in ends.tolist()], dtype=np.int64),
        )

    @classmethod
    def apart(cls, product: Product, each: Sequence[tuple[Sequence[int], Sequence[tuple[int, ...]], Start]]) -> Paths:
        """Return paths that share no steps; each is given by (K,) edges, (K + 1,) states of automata, and its start."""
        ends = np.cumsum([len(automata) for _, automata, _ in each], dtype=np.int64) - 1
        first = [int(end) + 1 - len(automata) for end, (_, automata, _) in zip(ends, each, strict=True)]
        before = np.arange(len(each) and ends[-1] + 1) - 1
        before[first] = first
        return cls(
            product,
            before,
            np.array(list(chain.from_iterable((-1, *edges) for edges, _, _ in each)), dtype=np.int64),
            np.array([q for _, automata, _ in each for q in automata], dtype=np.int64),
            {k: start for k, (_, _, start) in zip(first, each, strict=True)},
            ends,
        )

    def plan(self, number: int) -> Plan:
        """Return the plan of a path."""
        steps = [int(self.ends[number])]
        while steps[-1] not in self.starts:
            steps.append(int(self.before[steps[-1]]))
        steps.reverse()
        automata = list(map(tuple, self.automata[steps].tolist()))
        return plan_of(self.product, self.edges[steps[1:]], automata, self.starts[steps[0]])

    def objectives(self) -> list[tuple[Any, ...]]:
        """Return the exact objectives of every path, in the user's units.

        They are derived from the edges' costs and labels in the model, and the automata's readings of these labels, all
        paths at once, in whole numbers.

        Raises:
            AssertionError: a step is one that the model or an automaton does not have, or a task is not satisfied.
        """
        problem = self.product.problem
        violations = self._violations()
        costs = [
            [unit * count for count in self._spent[d][self.ends].tolist()] for d, unit in enumerate(problem.cost_units)
        ]
        counted = {0, *(o.cost for o in problem.objectives)}
        task_costs = {d: list(zip(*self._task_costs(d), strict=True)) for d in counted}
        values = [
            [o.measure.value(*amounts) for amounts in zip(task_costs[o.cost], violations, strict=True)]
            for o in problem.objectives
        ]
        return list(zip(*costs, *values, strict=True))

    @cached_property
    def _begins(self) -> np.ndarray:
        """(T,) bool, which steps are starts."""
        begins: np.ndarray = self.before == np.arange(len(self.before))
        return begins

    @cached_property
    def _states(self) -> np.ndarray:
        """(T,) the system's state after each step."""
        system, edges, later = self.product.problem.system.listed, self.edges[~self._begins], ~self._begins
        states = np.full(len(self.before), system.start, dtype=np.int64)
        states[later] = system.targets[edges]
        sources = states[self.before[later]]
        assert (system.offsets[sources] <= edges).all() and (edges < system.offsets[sources + 1]).all(), NO_STEP
        return states

    @cached_property
    def _spent(self) -> list[np.ndarray]:
        """For each cost, (T,) its total up to each step, in units."""
        problem, totals = self.product.problem, []
        for d, (column, unit) in enumerate(zip(problem.system.listed.costs, problem.cost_units, strict=True)):
            counts = column.counts(unit)
            steps = np.zeros(len(self.before), dtype=counts.dtype)
            steps[~self._begins] = counts[self.edges[~self._begins]]
            for k, start in self.starts.items():
                steps[k] = 0 if d else start.spent
            totals.append(self._sums(steps))
        return totals

    def _sums(self, values: np.ndarray) -> np.ndarray:
        """Return (T,) the sums of (T,) values from the start up to each step: twice as many steps in each round."""
        none = len(values)
        at, total = np.append(np.where(self._begins, none, self.before), none), np.append(values, values[:1] * 0)
        while (at < none).any():
            total, at = total + total[at], at[at]
        return total[:none]

    def _task_costs(self, cost: int) -> list[list[Any]]:
        """Return for all `priced` the cost (n,) of each path, in the user's units; 0 for rules."""
        problem, spent, columns = self.product.problem, self._spent[cost], []
        for i, dfa in enumerate(self.product.automata):
            done = self.automata[:, i] == dfa.automaton.accepting
            assert (done | (self.automata[:, i] == dfa.skipped))[self.ends].all(), (
                f"{problem.names[i]} is not satisfied"
            )
            # The step that satisfies the task, or else the start.
            at = np.where(done & (self._begins | ~done[self.before]), np.arange(len(done)), self.before)
            while ((further := at[at]) != at).any():
                at = further
            until = spent.copy()
            for k, start in self.starts.items():
                # The past has the first cost only.
                until[k] = 0 if cost else start.finished[i] or 0
            counts = np.where(done[self.ends], until[at[self.ends]], spent[self.ends])
            columns.append([problem.cost_units[cost] * count for count in counts.tolist()])
        return columns + [[0 * problem.cost_units[cost]] * len(self.ends)] * (len(problem.priced) - len(problem.tasks))

    def _violations(self) -> list[tuple[Any, ...]]:
        """Return the violation costs of all `priced` of each path, in the user's units."""
        problem, columns = self.product.problem, []
        followers: tuple[Follower, ...] = (*self.product.automata, *self.product.rules)
        for k, dfa in enumerate(followers):
            prices = self._prices(dfa, self.automata[:, k])
            for at, start in self.starts.items():
                assert start.automata[k] == self.automata[at, k], NO_STEP
                prices[at] = start.violations[k] if k < len(problem.priced) else 0
            if k < len(problem.priced):
                totals = self._sums(prices)[self.ends].tolist() if prices.any() else [0] * len(self.ends)
                columns.append([problem.units.price * count for count in totals])
        return list(zip(*columns, strict=True))

    def _prices(self, dfa: Follower, states: np.ndarray) -> np.ndarray:
        """Return (T,) what an automaton pays at each step, in units, given its state (T,) after each."""
        system, later = self.product.problem.system.listed, ~self._begins
        labels, size = system.labels[self._states[later]].astype(np.int64), dfa.size
        triples = (labels * size + states[self.before[later]]) * size + states[later]
        distinct, inverse = np.unique(triples, return_inverse=True)
        table = []
        for triple in distinct.tolist():
            (label, q), after = divmod(triple // size, size), triple % size
            price = next((r.price for r in dfa.readings(q, system.label_sets[label]) if r.state == after), None)
            assert price is not None, NO_STEP
            table.append(price)
        prices = np.zeros(len(states), dtype=object)
        prices[later] = np.array(table, dtype=object)[inverse]
        return prices


class GeneratedPaths(Paths):
    """The same where states are generated: `edges` holds the state after each step in place of an edge."""

    def objectives(self) -> list[tuple[Any, ...]]:
        """Return the exact objectives of every path, from its plan in the model."""
        values = []
        for number in range(len(self.ends)):
            values.append(Ledger.of_plan(self.product.problem, self.plan(number)).exact_objectives())
            check_limits()
        return values
