"""Algorithm 1 of the paper (constrained A*) and BOA*, in plain Python over exact numbers: what every search must find.

`_constrained_a_star` is Algorithm 1, with the paper's line numbers; a *label* is what the paper calls a node x. BOA*
(C. Hernandez Ulloa et al., "A Simple and Fast Bi-Objective Search Algorithm", ICAPS 2020) is the loop over it: after
each plan, mu_max falls below that plan's mu. Three things differ from the paper:

- Pruning. As printed, lines 14 and 15 prune nothing; pruning by g_min loses plans of lower mu. Here a label is dropped
  if another one of its product state is no worse in every entry of the *label key*, which depends on the preference's
  contract (`_key`): then every continuation is no worse either.
- Objectives. There may be several costs and preferences. f has a lower bound of each, mu_max is the set of vectors
  that no plan found so far dominates, and O is ordered by f, entry by entry.
- Relaxation (Remarks 1 to 6). A label may be read in several ways, for a price, and there are several x_0.

The compiled search does the same faster, and is tested against this one, which also takes numbers beyond 64 bits.
"""

from __future__ import annotations

import heapq
import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, partial
from itertools import chain, product
from operator import mul
from typing import Any

import numpy as np

from prefplan.errors import LimitError, PreferenceError
from prefplan.front import Stats
from prefplan.heuristics.cost_to_go import CHECK_PERIOD, max_min, task_distances
from prefplan.limits import check_limits, left
from prefplan.logic.weighted_dfa import Reading
from prefplan.preferences.contracts import LARGEST, TOLERANCE, text_of_costs, value_at
from prefplan.preferences.objective import Measure
from prefplan.preferences.terms import Term
from prefplan.product.product_automaton import Product, Start
from prefplan.search.paths import Goal, Result, ended_by, plan_of

BYTES_A_LABEL = 1500
"""Measured memory of a label with its key, and its share of the tables."""

SLACK = Fraction(TOLERANCE)
"""Relative tolerance of Python functions; a fraction, as some values are too large for floats."""

Vector = tuple[Any, ...]
Counts = tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Label:
    """A path: the paper's node x. There are D costs, N tasks, and P tasks and rules with violation costs.

    Attributes:
        state: state(x) = (s, q_1, ..., q_N, r_1, ..., r_R), where the path leads.
        g: (D,) its costs, as whole numbers of `Problem.cost_units`.
        pcs: (N,) its preference cost set (Definition 4): the costs (D,) of each task.
        violations: (P,) violation costs, in units.
        f: lower bounds of the costs, in units, and preferences of all plans that begin with the path.
        actions: number of actions.
        parent: parent(x), or the start of the path.
        edge: its last edge; -1 at the start.
    """

    state: Counts
    g: Counts
    pcs: tuple[Counts, ...]
    violations: Counts
    f: Vector
    actions: int
    parent: Label | Start
    edge: int


class ReferenceSearch:
    """Search for all non-dominated vectors of costs and preferences, whatever numbers a problem has."""

    def __init__(self, product: Product, *, bounds: Mapping[str, Fraction], single: bool = False) -> None:
        """Make the search ready.

        Args:
            product: what is searched.
            bounds: inclusive bounds of objectives by name, in the user's units.
            single: whether only the first point is wanted.

        Raises:
            LimitError: a limit was reached.
        """
        problem = product.problem
        self.product, self._problem, self._system = product, problem, product.listed
        self._units = [*problem.cost_units, *(Fraction(1) for _ in problem.objectives)]
        named = zip(problem.objective_names, self._units, strict=True)
        self._most = [bounds[name] / unit if name in bounds else math.inf for name, unit in named]
        edge_costs = zip(self._system.costs, problem.cost_units, strict=True)
        columns = [column.counts(unit).tolist() for column, unit in edge_costs]
        self._costs: list[Counts] = list(zip(*columns, strict=True))
        self._distances = [task_distances(product, column) for column in columns]
        self._readings = cache(self._read)
        self._open: list[tuple[Vector, int, int, Label]] = []
        self._undominated: dict[Vector, list[tuple[Vector, Label]]] = defaultdict(list)
        self._front: list[Vector] = []
        self._popped = self._made = 0
        self._complete_below, self._single, self._free = 0.0, single, left()[1]

    @property
    def work(self) -> Stats:
        """What was done so far."""
        return Stats(len(self._undominated), self._popped, self._made, self._made * BYTES_A_LABEL)

    def run(self) -> Result:
        """Search for the front in order of f (BOA*), or its first point; a limit or Ctrl-C may stop it before."""
        goals, ended = list[Label](), None
        try:
            for start in self.product.starts:
                self._begin(start)  # lines 1 to 4
            while not (goals and self._single) and (goal := self._constrained_a_star()) is not None:
                self._front.append(goal.f)
                goals.append(goal)
        except (LimitError, KeyboardInterrupt) as error:
            ended = ended_by(error)
        return Result(tuple(map(self._goal, goals)), ended, self._complete_below, self.work)

    def _begin(self, start: Start) -> None:
        """Add x_0 to O. Of a past, only the first cost counts."""
        costs = len(self._problem.cost_units)
        pcs = tuple(zip(*(start.task_costs(d) for d in range(costs)), strict=True))
        state = (self.product.graph.start, *start.automata)
        self._add(state, (start.spent, *[0] * (costs - 1)), pcs, start.violations, start, -1)

    def _constrained_a_star(self) -> Label | None:
        """Return the label of a goal within mu_max, of least f (Algorithm 1); None for failure.

        Raises:
            LimitError: a limit was reached.
        """
        while self._open:  # line 5
            *_, x = heapq.heappop(self._open)  # line 6
            self._complete_below = x.f[0]
            self._check()
            if not self._is_undominated(x) or not self._admits(x.f):  # line 7: g(x) > g_min, or mu_max has fallen
                continue
            if self._is_accepting(x.state):  # line 7
                return x  # line 8
            acc = self._acc(x.state)
            for edge, state, prices in self._successors(x.state):  # line 9
                cost = self._costs[edge]
                g = _plus(x.g, cost)  # line 10
                pcs = tuple(c if j in acc else _plus(c, cost) for j, c in enumerate(x.pcs))  # line 11, equation (3)
                self._add(state, g, pcs, _plus(x.violations, prices), x, edge)  # lines 12 to 18
        self._complete_below = math.inf
        return None  # line 19

    def _add(
        self, state: Counts, g: Counts, pcs: tuple[Counts, ...], violations: Counts, parent: Label | Start, edge: int
    ) -> None:
        """Create a label and add it to O, unless mu is too large, or another label of its product state is no worse."""
        f = self._f(state, g, pcs, violations)
        if isinstance(parent, Label):
            self._check_rise(parent.f, f, pcs, violations)
        if not self._admits(f):  # line 12
            return  # line 13
        actions = parent.actions + 1 if isinstance(parent, Label) else 0
        y = Label(state, g, pcs, violations, f, actions, parent, edge)  # lines 17 and 18
        key, others = self._key(y), self._undominated[self._place(y)]
        if any(_no_worse(other, key) for other, _ in others):  # line 14: g+ >= g_min
            return
        others[:] = [pair for pair in others if not _no_worse(key, pair[0])]
        others.append((key, y))  # line 15
        self._made += 1
        heapq.heappush(self._open, (f, actions, self._made, y))  # line 16

    def _check_rise(self, before: Vector, after: Vector, pcs: tuple[Counts, ...], violations: Counts) -> None:
        """Raise PreferenceError if a preference is less than before the last action (Definition 5)."""
        costs = len(self._problem.cost_units)
        for k, (one, other) in enumerate(zip(before[costs:], after[costs:], strict=False)):
            if other < one and one - other > one * SLACK:
                o, where = self._problem.objectives[k], self._problem.preferences[k].key
                at = text_of_costs(o.amounts([c[o.cost] for c in pcs], violations), self._problem.priced)
                raise PreferenceError(f"{where}: mu falls along a trajectory, on the last action to {at}")

    def _check(self) -> None:
        """Raise LimitError if a limit is reached."""
        self._popped += 1
        if self._popped % CHECK_PERIOD == 1:
            check_limits()
            if self.work.bytes > self._free:
                raise LimitError("memory")

    def _f(self, state: Counts, g: Counts, pcs: tuple[Counts, ...], violations: Counts) -> Vector:
        """Return g + h (equation 4) of every cost, infinite if no goal can be reached, and mu of every preference."""
        h = [max_min(distances, state) for distances in self._distances]
        if math.inf in h:
            return (math.inf,)
        amounts = (o.amounts([c[o.cost] for c in pcs], violations) for o in self._problem.objectives)
        return (*_plus(g, map(int, h)), *(self._mu(k, *each) for k, each in enumerate(amounts)))

    def _mu(self, k: int, costs: list[Fraction], violations: list[Fraction]) -> Any:
        """Return the k-th mu of a preference cost set in the user's units.

        Raises:
            PreferenceError: a formula or function has no value or a negative one, or a function one that is too large.
        """
        o = self._problem.objectives[k]
        try:
            value = o.value(costs, violations)
        except Exception:  # `value_at` says why
            value = math.nan
        if not 0 <= value <= (math.inf if isinstance(value, Fraction) else LARGEST):
            priced, where = self._problem.priced, self._problem.preferences[k].key
            for formula in o.formulas:
                value_at((costs, violations), formula, priced, where)
            raise PreferenceError(f"{where}: has no value at {text_of_costs((costs, violations), priced)}")
        return value

    def _admits(self, f: Vector) -> bool:
        """Return whether a plan with these values is within the user's bounds, and no plan found so far is as good."""
        is_within = f[0] < math.inf and all(value <= most for value, most in zip(f, self._most, strict=True))
        return is_within and not any(_no_worse(goal, f) for goal in reversed(self._front))

    def _is_undominated(self, x: Label) -> bool:
        """Return whether a label has not been replaced by a better one since it was added."""
        return any(x is other for _, other in self._undominated[self._place(x)])

    def _acc(self, state: Counts) -> set[int]:
        """Return the tasks that are satisfied in a product state."""
        pairs = zip(self.product.automata, state[1:], strict=False)
        return {j for j, (dfa, q) in enumerate(pairs) if q == dfa.automaton.accepting}

    def _is_accepting(self, state: Counts) -> bool:
        """Return whether all tasks are satisfied or skipped in a product state."""
        pairs = zip(self.product.automata, state[1:], strict=False)
        return all(q in (dfa.automaton.accepting, dfa.skipped) for dfa, q in pairs)

    def _successors(self, state: Counts) -> Iterator[tuple[int, Counts, Counts]]:
        """Yield the edge, the product state and the (P,) prices of each step (Definition 7)."""
        s, *automata = state
        for edge in self._system.edges(s):
            target = int(self.product.graph.targets[edge])
            label = int(self.product.graph.classes[target])
            for readings in product(*(self._readings(k, q, label) for k, q in enumerate(automata))):
                prices = tuple(reading.price for reading in readings[: len(self._problem.priced)])
                yield edge, (target, *(reading.state for reading in readings)), prices

    def _read(self, k: int, q: int, label: int) -> list[Reading]:
        """Return the ways in which automaton k may read a label class; none if that breaks an unbreakable rule."""
        return self.product.followers[k].readings(q, self.product.class_sets[label])

    def _key(self, x: Label) -> Vector:
        """Return the label key; `prefplan.preferences.objective` says why these entries suffice."""
        entries = [self._entries(x, objective) for objective in self._problem.objectives]
        return (*x.g, *chain.from_iterable(entries))

    def _entries(self, x: Label, o: Measure) -> Vector:
        """Return the entries of the label key for one preference."""
        if o.contract == "general":
            return x.violations
        costs, violations = o.amounts([c[o.cost] for c in x.pcs], x.violations)
        if o.bi_objective:
            return (o.value(costs, violations),)
        single: list[Term] = [*o.maxima, *(f for f in o.formulas if f.contract != "componentwise")]
        mixed = [f for f in o.formulas if f.contract == "componentwise"]
        return (
            o.summed(costs, violations),
            *(term.value(costs, violations) for term in single),
            *(x.pcs[j][o.cost] for j in sorted({j for f in mixed for j in f.costs})),
            *(x.violations[j] for j in sorted({j for f in mixed for j in f.violations})),
        )

    def _place(self, x: Label) -> Vector:
        """Return what labels must share to be compared: the product state; for a general contract all costs, too."""
        general = sorted({o.cost for o in self._problem.objectives if o.contract == "general"})
        return (x.state, *((x.g[d], *(c[d] for c in x.pcs)) for d in general))

    def _goal(self, goal: Label) -> Goal:
        """Return a goal with its exact objectives, in the user's units, and its path (extractPlan)."""
        path = [goal]
        while isinstance(parent := path[-1].parent, Label):
            path.append(parent)
        path.reverse()
        edges, automata = [[x.edge] for x in path[1:]], np.array([x.state[1:] for x in path])
        make = partial(plan_of, self.product, parent, edges, automata)
        return Goal(tuple(map(mul, goal.f, self._units)), make)


def _plus(one: Counts, other: Iterable[int]) -> Counts:
    return tuple(a + b for a, b in zip(one, other, strict=True))


def _no_worse(one: Vector, other: Vector) -> bool:
    return all(a <= b for a, b in zip(one, other, strict=True))
