"""What a search returns: its goals, and plans, derived from the model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from typing import Any

import numpy as np

from prefplan.errors import LimitError
from prefplan.exact_costs import Number, exact, to_number
from prefplan.front import Stats
from prefplan.ledger import Ledger
from prefplan.plan import Plan, Purchase
from prefplan.product.product_automaton import NO_STEP, Product, Start

UNSATISFIED = "a task is not satisfied"
OTHER_VALUES = "a plan has other values in the model"


def plan_of(product: Product, start: Start, edges: Sequence[list[int]], automata: np.ndarray) -> Plan:
    """Return the plan of a path of k steps through a product, all its values computed again from the model.

    Args:
        product: what was searched.
        start: how the path begins.
        edges: (k,) the system's edges that each step stands for, or the state that it leads to where states are
            generated.
        automata: (k + 1, N + R) states of the automata at the start and after each step.

    Raises:
        AssertionError: a step is one that the product does not have, or a task is not satisfied.
    """
    assert all(edges), NO_STEP
    # No automaton moves before the last edge of a step.
    automata = np.repeat(automata, [*map(len, edges), 1], axis=0)
    problem, taken = product.problem, product.actions(np.array([*chain(*edges)], dtype=np.int64))
    past = problem.past
    actions, states, labels, (first, *more) = past.along(product.system, (*past.actions, *taken))
    purchases = _purchases(product, start, automata, labels)
    further = dict(zip(problem.cost_names[1:], more, strict=True))
    ledger = Ledger.of(problem, actions, first, labels, purchases, further)
    assert all(ledger.states[name] is None for name, at in ledger.satisfied.items() if at is None), UNSATISFIED
    final, values = ledger.final, dict(zip(problem.objective_names, ledger.exact_objectives(), strict=True))
    return Plan(
        cost=final.cost,
        preference=final.preference,
        task_costs=final.task_costs,
        violation_costs=final.violation_costs,
        actions=actions,
        states=states,
        relaxations=tuple(replace(purchase, cost=to_number(exact(purchase.cost))) for purchase in purchases),
        costs={name: to_number(values[name]) for name in problem.cost_names},
        preferences={named.name: to_number(values[named.name]) for named in problem.preferences},
        display=problem.display,
    )


def _purchases(
    product: Product, start: Start, automata: np.ndarray, labels: Sequence[frozenset[str]]
) -> list[Purchase]:
    """Return the relaxations used along (K + 1,) states of the automata, and the rules broken, in order of steps.

    `labels` begin with those of the past; the automata read the last K + 1 of them.
    """
    problem = product.problem
    first, price, purchases = len(labels) - len(automata), problem.measure.price_unit, list[Purchase]()
    for i, (name, dfa) in enumerate(zip(problem.names, product.automata, strict=True)):
        if start.relaxed[i] is None:
            purchases.append(Purchase(name, 0, None, (dfa.skip or 0) * price))
        relaxed, states = [*(start.relaxed[i] or ())], automata[:, i].tolist()
        for k in range(1, len(states) if dfa.relaxations else 0):
            readings = dfa.readings(states[k - 1], labels[first + k])
            reading = next((reading for reading in readings if reading.state == states[k]), None)
            assert reading is not None, NO_STEP
            relaxed += [(first + k, relaxation) for relaxation in reading.relaxations]
        for k, relaxation in relaxed:
            assumed, _, count = dfa.relaxations[relaxation]
            purchases.append(Purchase(name, k, assumed, count * price))
    prices = {rule.name: rule.skip for rule in problem.rules}
    broken = problem.broken(labels).items()
    purchases += [Purchase(name, step, None, exact(prices[name] or 0), rule=True) for name, step in broken]
    return sorted(purchases, key=lambda purchase: purchase.step)


@dataclass(frozen=True)
class Goal:
    """A goal that a search found.

    Attributes:
        objectives: exact values of all costs and preferences, in the user's units.
        make: returns the plan that leads to it, as `plan_of`.
    """

    objectives: tuple[Any, ...]
    make: Callable[[], Plan] = field(repr=False)

    @cached_property
    def point(self) -> tuple[Number, ...]:
        """The values of all costs and preferences as they are printed."""
        return tuple(map(to_number, self.objectives))

    @cached_property
    def plan(self) -> Plan:
        """The plan that leads to the goal; it is asserted that its values in the model are those of the search."""
        plan = self.make()
        assert tuple(plan.objectives.values()) == self.point, OTHER_VALUES
        return plan


@dataclass(frozen=True)
class Result:
    """What a search has found so far.

    Attributes:
        goals: points of the front, in order of the objectives; if none is known, one goal that is known, or none.
        ended: what stopped the search: `time`, `memory` or `interrupt`; None if nothing did.
        complete_below: all points of lower cost, units, are among the goals; infinite once the search ran to its end.
        work: of the search.
    """

    goals: tuple[Goal, ...] = ()
    ended: str | None = None
    complete_below: float = 0
    work: Stats = Stats()


def ended_by(error: LimitError | KeyboardInterrupt) -> str:
    """Return what stopped a search that an error ended; see `Result.ended`."""
    return error.ended if isinstance(error, LimitError) else "interrupt"
