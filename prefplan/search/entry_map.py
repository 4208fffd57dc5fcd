"""What the entries of a label are where there are several costs or preferences (`ltmoa_star`)."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from prefplan.preferences.objective import PreferenceObjective
from prefplan.problem import Problem


@dataclass(frozen=True)
class EntryMap:
    """Where the entries of labels are.

    Attributes:
        costs: how many costs there are.
        additive: the preferences with an additive entry, in the order of these.
        maxima: for each maximum entry the preference, and its place among the preference's maxima.
        frozen: for each entry of a satisfied task's cost the cost and the task.
        paid: the task of each violation cost.
    """

    costs: int
    additive: tuple[PreferenceObjective, ...]
    maxima: tuple[tuple[PreferenceObjective, int], ...]
    frozen: tuple[tuple[int, int], ...]
    paid: tuple[int, ...]

    @classmethod
    def of(cls, problem: Problem) -> EntryMap:
        """Return the entries that a problem's objectives need."""
        objectives = problem.objectives
        mentioned = [(o.cost, f) for o in objectives for f in o.measure.formulas]
        return cls(
            len(problem.cost_names),
            tuple(o for o in objectives if not (o.measure.bi_objective and o.measure.maxima)),
            tuple((o, k) for o in objectives for k in range(len(o.measure.maxima))),
            tuple(sorted({(cost, i) for cost, f in mentioned for i in f.costs})),
            tuple(sorted({i for _, f in mentioned for i in f.violations})),
        )

    @property
    def count(self) -> int:
        """Number of entries."""
        return self.costs + len(self.additive) + len(self.maxima) + len(self.frozen) + len(self.paid)

    def alone(self, objective: PreferenceObjective) -> int | None:
        """Return the entry that is a preference's value, None if there is no such entry."""
        if not objective.measure.bi_objective:
            return None
        if objective in self.additive:
            return self.costs + self.additive.index(objective)
        return self.costs + len(self.additive) + self.maxima.index((objective, 0))

    def value(self, objective: PreferenceObjective, entries: list[int], spent: list[int]) -> Any:
        """Return the exact value of a preference at a goal.

        Args:
            objective: the preference.
            entries: of the goal.
            spent: every total cost, in units.
        """
        units, measure, first = objective.units, objective.measure, self.costs
        value = measure.constant
        if objective in self.additive:
            value += entries[first + self.additive.index(objective)] * units.mu
        first += len(self.additive)
        for m, (owner, _) in enumerate(self.maxima):
            if owner is objective:
                value += entries[first + m] * units.mu
        first += len(self.maxima)
        costs = [Fraction(0)] * measure.tasks
        for c, (cost, i) in enumerate(self.frozen):
            if cost == objective.cost:
                costs[i] = entries[first + c] * units.cost
        first += len(self.frozen)
        violations = [Fraction(0)] * measure.tasks
        for v, i in enumerate(self.paid):
            violations[i] = entries[first + v] * units.price
        return sum((formula.value(costs, violations) for formula in measure.formulas), value)
