"""What a search returns: its goals, the paths to them as arrays, and plans and values, derived from the model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from prefplan.errors import LimitError
from prefplan.exact_costs import INT64_LIMIT, Number, exact, to_number
from prefplan.front import Stats
from prefplan.ledger import Ledger
from prefplan.limits import check_limits
from prefplan.logic.weighted_dfa import WeightedAutomaton
from prefplan.plan import Plan, Purchase
from prefplan.product.contraction import edges_between
from prefplan.product.product_automaton import Product, Start
from prefplan.product.space import Graph

NO_STEP = "the search made a step that the model does not have"
OTHER_VALUES = "a plan has other values in the model"


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

    def through(self, graph: Graph, costs: np.ndarray) -> Paths:
        """Return the paths with the edges between the nodes of a contracted graph, which are here in place of edges.

        The (T,) costs are those up to each node, as in `Graph.costs`; see `edges_between`.
        """
        before, edges, automata, last = list[int](), list[int](), list[int](), list[int]()
        states, nodes, spent = self.automata.tolist(), self.edges.tolist(), costs.tolist()
        for k, at in enumerate(self.before.tolist()):
            passed = [-1]
            if at != k:
                passed = edges_between(self.product, graph, nodes[at], nodes[k], states[at], spent[k] - spent[at])
                assert passed, NO_STEP
            first = len(edges)
            before += [first if at == k else last[at], *range(first, first + len(passed) - 1)]
            edges += passed
            automata += [*[at] * (len(passed) - 1), k]
            last.append(len(edges) - 1)
        return Paths(
            self.product,
            np.array(before, dtype=np.int64),
            np.array(edges, dtype=np.int64),
            self.automata[np.array(automata, dtype=np.int64)],
            {last[k]: start for k, start in self.starts.items()},
            np.array(last, dtype=np.int64)[self.ends],
        )

    def plan(self, number: int) -> Plan:
        """Return the plan of a path, all its values computed again from the model."""
        steps = [int(self.ends[number])]
        while steps[-1] not in self.starts:
            steps.append(int(self.before[steps[-1]]))
        steps.reverse()
        problem, past = self.product.problem, self.product.problem.past
        taken = self.product.actions(self.edges[steps[1:]])
        actions, states, labels, (first, *more) = self.product.system.trajectory(taken)
        labels = [*past.labels, *labels]
        purchases = self._purchases(steps, labels)
        actions, first = (*past.actions, *actions), (*map(exact, past.costs), *first)
        further = dict(zip(problem.cost_names[1:], more, strict=True))
        ledger = Ledger.of(problem, actions, first, labels, purchases, further)
        final, values = ledger.final, dict(zip(problem.objective_names, ledger.exact_objectives(), strict=True))
        return Plan(
            cost=final.cost,
            preference=final.preference,
            task_costs=final.task_costs,
            violation_costs=final.violation_costs,
            actions=ledger.actions,
            states=(*past.states, *states),
            relaxations=tuple(replace(purchase, cost=to_number(exact(purchase.cost))) for purchase in purchases),
            costs={name: to_number(values[name]) for name in problem.cost_names},
            preferences={named.name: to_number(values[named.name]) for named in problem.preferences},
            display=problem.display,
        )

    def _purchases(self, steps: Sequence[int], labels: Sequence[frozenset[str]]) -> list[Purchase]:
        """Return the relaxations used along some steps and the rules broken, in order; labels are the past's, too."""
        product, problem, start = self.product, self.product.problem, self.starts[steps[0]]
        first, price, purchases = len(labels) - len(steps), problem.measure.price_unit, list[Purchase]()
        for i, (name, dfa) in enumerate(zip(problem.names, product.automata, strict=True)):
            if start.relaxed[i] is None:
                purchases.append(Purchase(name, 0, None, (dfa.skip or 0) * price))
            relaxed, states = [*(start.relaxed[i] or ())], self.automata[steps, i].tolist()
            for k in range(1, len(steps) if dfa.relaxations else 0):
                readings = dfa.readings(states[k - 1], labels[first + k])
                reading = next(reading for reading in readings if reading.state == states[k])
                relaxed += [(first + k, relaxation) for relaxation in reading.relaxations]
            for k, relaxation in relaxed:
                assumed, _, count = dfa.relaxations[relaxation]
                purchases.append(Purchase(name, k, assumed, count * price))
        prices = {rule.name: rule.skip for rule in problem.rules}
        broken = problem.broken(labels).items()
        purchases += [Purchase(name, step, None, exact(prices[name] or 0), rule=True) for name, step in broken]
        return sorted(purchases, key=lambda purchase: purchase.step)

    def objectives(self) -> list[tuple[Any, ...]]:
        """Return the exact objectives of every path, in the user's units.

        They are derived from the edges' costs and labels in the model, and the automata's readings of these labels, all
        paths at once, in whole numbers.

        Raises:
            AssertionError: a step is one that the model or an automaton does not have, or a task is not satisfied.
        """
        problem, ends = self.product.problem, self.product.tables.ends
        tasks, costs = self.automata[:, : len(ends)], len(problem.cost_names)
        done = tasks == ends[:, 0]
        assert (done | (tasks == ends[:, 1]))[self.ends].all(), "a task is not satisfied"
        totals = self._added()
        task_costs = np.zeros((len(done), costs, len(ends)), totals.dtype)
        for k, start in self.starts.items():
            task_costs[k] = [start.task_costs(d) for d in range(costs)]
        for level in self._levels():
            before = self.before[level]
            totals[level] += totals[before]
            # Equation (3).
            task_costs[level] = np.where(done[before, None], task_costs[before], totals[level, :costs, None])
        found = []
        for total, each in zip(totals[self.ends].tolist(), task_costs[self.ends].tolist(), strict=True):
            spent = (unit * count for unit, count in zip(problem.cost_units, total, strict=False))
            values = (o.value(*o.amounts(each[o.cost], total[costs:])) for o in problem.objectives)
            found.append((*spent, *values))
        return found

    def _added(self) -> np.ndarray:
        """Return (T, D + P) what each step adds to all costs, then violation costs, in units; a start its past's."""
        problem, system = self.product.problem, self.product.problem.system.listed
        later = np.flatnonzero(self.before != np.arange(len(self.before)))
        before, edges = self.before[later], self.edges[later]
        states = np.full(len(self.before), system.start, dtype=np.int64)
        states[later] = system.targets[edges]
        first = system.offsets[states[before]], system.offsets[states[before] + 1]
        assert (first[0] <= edges).all() and (edges < first[1]).all(), NO_STEP
        columns = [each.counts(unit)[edges] for each, unit in zip(system.costs, problem.cost_units, strict=True)]
        labels = system.labels[states[later]]
        for dfa, after in zip(self.product.followers, self.automata.T, strict=True):
            columns.append(_prices(dfa, system.label_sets, labels, after[before], after[later]))
        added = np.zeros((len(self.before), len(system.costs) + len(problem.priced)), dtype=object)
        added[later] = np.stack(columns[: added.shape[1]], axis=1)
        for k, start in self.starts.items():
            assert start.automata == tuple(self.automata[k].tolist()), NO_STEP
            added[k] = [start.spent, *[0] * (len(system.costs) - 1), *start.violations]
        return added.astype(np.int64) if added.size * added.max() < INT64_LIMIT else added

    def _levels(self) -> list[np.ndarray]:
        """Return the steps by how many come before them in their path, without the starts."""
        depths = list[int]()
        for k, before in enumerate(self.before.tolist()):
            depths.append(0 if before == k else depths[before] + 1)
        return np.split(np.argsort(depths, kind="stable"), np.cumsum(np.bincount(depths)))[1:-1]


class GeneratedPaths(Paths):
    """The same where states are generated: `edges` holds the state after each step in place of an edge."""

    def objectives(self) -> list[tuple[Any, ...]]:
        """Return the exact objectives of every path, from its plan in the model."""
        found = []
        for number in range(len(self.ends)):
            found.append(Ledger.of_plan(self.product.problem, self.plan(number)).exact_objectives())
            check_limits()
        return found


def _prices(
    dfa: WeightedAutomaton,
    label_sets: Sequence[frozenset[str]],
    labels: np.ndarray,
    before: np.ndarray,
    after: np.ndarray,
) -> np.ndarray:
    """Return the prices, in units, of steps of an automaton, given the label read and the states before and after."""
    size = dfa.size
    triples, prices = (labels.astype(np.int64) * size + before) * size + after, list[int]()
    distinct, inverse = np.unique(triples, return_inverse=True)
    for triple in distinct.tolist():
        label, q = divmod(triple // size, size)
        price = next((r.price for r in dfa.readings(q, label_sets[label]) if r.state == triple % size), None)
        assert price is not None, NO_STEP
        prices.append(price)
    return np.array(prices, dtype=object)[inverse]


@dataclass(frozen=True)
class Goal:
    """A goal that a search found.

    Attributes:
        objectives: exact values of all costs and preferences, in the user's units.
        paths: the paths to all goals of the search.
        number: which of them leads to this one.
    """

    objectives: tuple[Any, ...]
    paths: Paths = field(repr=False)
    number: int

    @cached_property
    def point(self) -> tuple[Number, ...]:
        """The values of all costs and preferences as they are printed."""
        return tuple(map(to_number, self.objectives))

    @cached_property
    def plan(self) -> Plan:
        """The plan that leads to the goal; it is asserted that its values in the model are those of the search."""
        plan = self.paths.plan(self.number)
        assert tuple(plan.objectives.values()) == self.point, OTHER_VALUES
        return plan


@dataclass(frozen=True)
class Result:
    """What a search has found so far.

    Attributes:
        goals: points of the front, in order of the objectives.
        ended: what stopped it: `time`, `memory` or `interrupt`; None if nothing did.
        complete_below: all points of lower cost, units, are among the goals; infinite once the search ran to its end.
        work: of the search.
        incumbents: where there is no goal, the goal of a plan that need not be a point of the front, if one is known.
    """

    goals: tuple[Goal, ...] = ()
    ended: str | None = None
    complete_below: float = 0
    work: Stats = Stats()
    incumbents: tuple[Goal, ...] = ()

    def check(self) -> None:
        """Assert that the values of all goals are those that their paths have in the model."""
        if self.goals:
            derived = self.goals[0].paths.objectives()
            for goal in self.goals:
                values = derived[goal.number]
                assert values == goal.objectives or tuple(map(to_number, values)) == goal.point, OTHER_VALUES


def ended_by(error: LimitError | KeyboardInterrupt) -> str:
    """Return what stopped a search that an error ended; see `Result.ended`."""
    return error.ended if isinstance(error, LimitError) else "interrupt"
