"""The exact front of a small problem with rules, by exhaustive search with monitors of bad prefixes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from judge.enumerate import Node, Product, Reading, undominated
from judge.preferences import Mu, Number, Values
from judge.problems import GraphProblem, JudgedTask
from judge.semantics import Label, monitor
from judge.syntax import Formula

GONE = -3
"""In place of a monitor's state: the rule was broken, and paid for."""


class JudgedRule(NamedTuple):
    """A rule; its bad prefixes satisfy `bad`, and `skip` is the price of breaking it, None if it may not be broken."""

    name: str
    bad: Formula
    skip: Number | None = None


class RuledProduct(Product):
    """A product in whose nodes the states of the rules' monitors follow those of the tasks."""

    def __init__(self, problem: GraphProblem, rules: Sequence[JudgedRule]) -> None:
        """Build every reachable node."""
        self.rules, self.tasks = rules, len(problem.tasks)
        watched = (JudgedTask(rule.name, rule.bad) for rule in rules)
        super().__init__(replace(problem, tasks=(*problem.tasks, *watched)))

    def finished(self, node: Node) -> bool:
        """Return whether a plan may end here: rules do not prevent it."""
        return super().finished((node[0], node[1][: self.tasks]))

    def _readings_of(self, k: int, state: int, label: Label) -> list[Reading]:
        if k < self.tasks:
            return super()._readings_of(k, state, label)
        rule = self.rules[k - self.tasks]
        after = state if state == GONE else monitor(rule.bad).step(state, label)
        if after == GONE or not monitor(rule.bad).satisfied(after):
            return [(after, ())]
        return [] if rule.skip is None else [(GONE, ((rule.name, rule.skip),))]


def front_with_rules(
    problem: GraphProblem, rules: Sequence[JudgedRule], mu: Mu, *, max_cost: Number
) -> list[tuple[Number, Number]]:
    """Return the non-dominated (cost, mu) of cost at most `max_cost`, by rising cost.

    Args:
        problem: without the rules.
        rules: what no plan breaks, or only for a price.
        mu: of the costs and violation costs of the tasks and then of the rules; it falls in none of them.
        max_cost: greatest total cost, inclusive.
    """

    def worth(spent: Values, ends: Sequence[Values], paid: Values) -> Values:
        return spent[0], mu(tuple(end[0] for end in ends), paid)

    return [(point[0], point[1]) for point in undominated(RuledProduct(problem, rules), worth, limits=(max_cost,))]
