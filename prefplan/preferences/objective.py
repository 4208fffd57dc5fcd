"""A preference bound to a problem: exact values of mu, and the label keys by which the search compares labels.

| terms                                               | label key                                              |
| --------------------------------------------------- | ------------------------------------------------------ |
| rates, violation sums, tardiness                    | their sum, as one entry                                |
| one maximum and nothing else                        | its value                                              |
| several maxima, or a maximum beside others          | the value of each                                      |
| formulas, `componentwise`                           | c_i of satisfied tasks and v_i that they mention       |
| formulas, `general`                                 | v_i; only labels with equal g and c_i are compared     |
| formulas declared `additive` or `convex`            | the value of each                                      |

g is the total cost and S the set of satisfied tasks. One entry is enough for rates and tardiness: the future growth of
a rate depends on S alone, and the tardiness of an unsatisfied task is a convex function of g. So of two labels of one
product state, the one with the smaller (g, entry) remains the better one. A lone maximum m = max_i w_i c_i continues
as max(m, w_i (g + ...)), which does not decrease in (g, m).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, is_dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from prefplan.errors import PreferenceError, PrefplanError, check_known, describe
from prefplan.exact_costs import common_unit
from prefplan.preferences.expression import is_rounded, scaled
from prefplan.preferences.kinds import Preference
from prefplan.preferences.terms import (
    Maximum,
    OpaqueTerm,
    Rate,
    Tardiness,
    Term,
    Violation,
    weights_of,
    with_weights,
)
from prefplan.text.forms import check_fields
from prefplan.text.names import check_names

TASK_LIMIT = 20
"""Most tasks: tables over all satisfied sets have 2^N entries."""

DEFAULT_PREFERENCE = "preference"
"""Name of a preference that is given without one."""

ONE = Fraction(1)

EXAMPLES = 'such as Order(), WeightedSum({"TASK": 1}) or Function(f)'
"""Preferences in Python, for messages."""


@dataclass(frozen=True)
class NamedPreference:
    """One of several preferences.

    Attributes:
        name: its name.
        preference: the preference function.
        of: name of the cost in which the tasks' costs are measured; None for the first.
    """

    name: str
    preference: Preference = field(metadata={"key": None})
    of: str | None = None

    @property
    def key(self) -> str:
        """Its key as in a scenario file, for messages."""
        return "preference" if self.name == DEFAULT_PREFERENCE else f"preferences.{self.name}"


def preferences_of(given: Preference | Sequence[NamedPreference]) -> tuple[NamedPreference, ...]:
    """Return one preference that is given by itself, or several with their names.

    Raises:
        PreferenceError: it is something else.
    """
    if isinstance(given, str) or not isinstance(given, Sequence):
        given = [NamedPreference(DEFAULT_PREFERENCE, given)]
    for i, one in enumerate(given):
        if not isinstance(one, NamedPreference):
            raise PreferenceError(
                f"preference[{i}]: must be like NamedPreference('NAME', Order()), not {describe(one)}; a preference "
                f"alone needs no list, {EXAMPLES}"
            )
        if isinstance(one.preference, type) or not hasattr(one.preference, "terms"):
            raise PreferenceError(f"{one.key}: must be a preference, {EXAMPLES}, not {describe(one.preference)}")
        if is_dataclass(one.preference):
            check_fields(one.preference, PreferenceError, f"{one.key}.")
    return tuple(given)


def check_objective_names(preferences: Sequence[NamedPreference], costs: Sequence[str]) -> None:
    """Check that the names of costs and preferences are distinct, and that `of` names a cost.

    Raises:
        PrefplanError: they are not, or there is neither a preference nor more than one cost.
    """
    if not preferences and len(costs) == 1:
        raise PrefplanError(f"preference: missing, {EXAMPLES}; it may be left out only if there are several costs")
    taken = list(costs)
    for named in preferences:
        where = named.key
        check_names([named.name], where=f"{where}.name")
        if named.name in taken:
            raise PrefplanError(f"{where}.name: {named.name!r} is used twice (names so far: {', '.join(taken)})")
        if named.of is not None:
            check_known(f"{where}.of", "cost", named.of, costs, PrefplanError)
        taken.append(named.name)


class Measure:
    """A preference as one of a problem's objectives: a sum of terms over N tasks and P violation costs.

    Violation costs are those of the tasks, then of the rules that may be broken.

    Attributes:
        name: its name.
        cost: index of the cost in which the tasks' costs are measured.
        tasks: N, the number of tasks.
        constant: the constant summand.
        rate_terms: the additive terms over cost.
        violation_weights: (P,) weights of the violation costs in additive terms.
        tardiness: the deadlines.
        one_entry: rates, violation sums and deadlines, whose sum is one entry of a label key.
        maxima: the weighted maxima.
        formulas: Python functions, and all other expressions.
        bi_objective: whether (g, mu) is a sufficient label key.
        weighs_violation: whether any term depends on violation costs.
        claimed: whether the contract was declared by the user: tested on random costs, not proven.
        is_whole: whether all values are whole multiples of `unit`: no term is a Python function or has a division.
        largest_rate: an upper bound of the growth of rates and tardiness per unit of cost.
        cost_unit: unit of costs, in the user's units.
        price_unit: unit of violation costs.
        unit: unit of mu, in which all terms without functions or divisions are whole.
        factor: the unit of cost, in units of mu.
    """

    def __init__(
        self,
        parts: Sequence[Term | Fraction],
        tasks: int,
        rules: int = 0,
        cost_unit: Fraction = ONE,
        price_unit: Fraction = ONE,
        *,
        name: str = DEFAULT_PREFERENCE,
        cost: int = 0,
    ) -> None:
        """Take terms and constants, numbers of tasks and breakable rules, and units of the cost and of prices."""
        self.name, self.cost, self.tasks = name, cost, tasks
        self.cost_unit, self.price_unit = cost_unit, price_unit
        self.constant = sum(_of_kind(parts, Fraction), Fraction(0))
        self.rate_terms: tuple[Rate, ...] = _of_kind(parts, Rate)
        self.tardiness: tuple[Tardiness, ...] = _of_kind(parts, Tardiness)
        self.one_entry: tuple[Rate | Violation | Tardiness, ...] = _of_kind(parts, Rate | Violation | Tardiness)
        self.maxima: tuple[Maximum, ...] = _of_kind(parts, Maximum)
        self.formulas: tuple[OpaqueTerm, ...] = _of_kind(parts, OpaqueTerm)
        violations: tuple[Violation, ...] = _of_kind(parts, Violation)
        self.violation_weights = [sum((v.weights[i] for v in violations), Fraction(0)) for i in range(tasks + rules)]
        self.weighs_violation = bool(violations) or any(formula.violations for formula in self.formulas)
        self.bi_objective = not self.formulas and len(self.maxima) <= (0 if self.one_entry else 1)
        self.claimed = any(formula.claimed for formula in self.formulas)
        self.is_whole = not any(is_rounded(formula.tree) for formula in self.formulas)
        growing = [weight for term in (*self.rate_terms, *self.tardiness) for weight in weights_of(term)]
        self.largest_rate = tasks * sum(growing, Fraction(0))
        amounts = [weight * cost_unit for weight in (*growing, *(w for term in self.maxima for w in term.weights))]
        amounts += [late.weight * late.by for late in self.tardiness]
        amounts += [weight * price_unit for weight in self.violation_weights]
        amounts += [formula.weight * scaled(formula.tree, cost_unit, price_unit)[1] for formula in self.formulas]
        self.unit = common_unit(amounts)
        self.factor = cost_unit / self.unit

    def amounts(self, costs: Sequence[int], violations: Sequence[int]) -> tuple[list[Fraction], list[Fraction]]:
        """Return (P,) costs and violation costs in the user's units, given tasks' costs and (P,) prices in units."""
        rules = [Fraction(0)] * (len(violations) - len(costs))
        return [*(count * self.cost_unit for count in costs), *rules], [v * self.price_unit for v in violations]

    def value(self, costs: Sequence[Fraction], violations: Sequence[Fraction]) -> Any:
        """Return mu of a preference cost set in the user's units: a fraction, or a float where functions are used."""
        others: tuple[Term, ...] = (*self.maxima, *self.formulas)
        return self.constant + self.summed(costs, violations) + sum(term.value(costs, violations) for term in others)

    def summed(self, costs: Sequence[Fraction], violations: Sequence[Fraction]) -> Fraction:
        """Return the one entry for a preference cost set, in the user's units."""
        return sum((term.value(costs, violations) for term in self.one_entry), Fraction(0))

    @property
    def contract(self) -> str:
        """The weakest contract that covers all terms."""
        if any(formula.contract == "general" for formula in self.formulas):
            return "general"
        if self.bi_objective:
            return "convex" if self.tardiness or self.maxima else "additive"
        if len(self.formulas) == 1 and not self.maxima and not self.one_entry:
            return self.formulas[0].contract
        return "componentwise"

    def rates(self, terms: Sequence[Rate | Maximum], tasks: Sequence[int] | None = None) -> np.ndarray:
        """Return the (2^k,) int64 sum of some terms, in units, for each satisfied set of k tasks (by default all).

        Each of these tasks costs one unit if it is not satisfied, else nothing; other tasks cost nothing.
        """
        tasks = range(self.tasks) if tasks is None else tasks
        sets = np.arange(2 ** len(tasks))
        costs = np.zeros((len(self.violation_weights), len(sets)), dtype=np.int8)
        for j, i in enumerate(tasks):
            costs[i] = 1 - (sets >> j & 1)
        whole = [with_weights(term, lambda weight: np.int64(weight * self.factor)) for term in terms]
        return sum((term.value(costs, ()) for term in whole), start=0 * sets)


def _of_kind(terms: Sequence[Term | Fraction], kind: Any) -> tuple[Any, ...]:
    return tuple(term for term in terms if isinstance(term, kind))
