"""Preference functions mu over the tasks' costs (Definition 5); lower is better.

A preference is written in terms of task names and the user's units. `terms` splits it into terms for which the search
has label keys; `prefplan.preferences.objective` binds these to a problem.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial, reduce
from itertools import chain
from operator import mul
from typing import Annotated, Any, Protocol

import numpy as np

from prefplan.errors import ModelError, PreferenceError, check_known, choices, prefixed
from prefplan.exact_costs import Number, exact
from prefplan.preferences.analysis import decompose, shape
from prefplan.preferences.contracts import CONTRACTS, SPAN, check_contract, check_never_falls, value_at
from prefplan.preferences.expression import Constant, Operation, Tree, Variable, evaluate, parse
from prefplan.preferences.terms import OpaqueTerm, OrderRate, Term, checked_terms, with_weights
from prefplan.text.forms import Form

OVER = ("cost", "violation")

WEIGHTS = Form("weights by task, such as { TASK = 2 }", 'weights by task, such as {"TASK": 2}')


class Preference(Protocol):
    """The interface of a preference: any object with this method is one."""

    def terms(self, tasks: Sequence[str], rules: Sequence[str] = ()) -> list[Term | Fraction]:
        """Return the terms whose sum is mu, for these tasks; fractions are constants.

        `rules` are those that may be broken, numbered after the tasks: they have violation costs, and cost 0. The
        argument is left out if there are none.

        Raises:
            PreferenceError: with the key in front, if the preference does not fit the tasks.
        """


@dataclass(frozen=True)
class Order:
    """Delay against a desired order of satisfaction (the paper's Example 3).

    mu = sum_k max(0, c_{o_k} - c*_k), with o the desired order and c* the sorted costs; members of a group are
    interchangeable, i.e. mu is the smallest over all orders of a group's members.

    Attributes:
        order: names of tasks, each once, or groups of names; None for the problem's order. Other tasks do not count.
    """

    order: Annotated[
        tuple[str | tuple[str, ...], ...] | None,
        Form('a list of tasks, such as ["TASK1", "TASK2"], or of groups of tasks', 'a list such as ["TASK1", "TASK2"]'),
    ] = None

    def groups(self, tasks: Sequence[str]) -> list[tuple[str, ...]]:
        """Return the groups in order, for a problem's tasks; a task on its own is a group."""
        order = tasks if self.order is None else self.order
        return [(entry,) if isinstance(entry, str) else tuple(entry) for entry in order]

    def terms(self, tasks: Sequence[str], rules: Sequence[str] = ()) -> list[Term | Fraction]:
        """Return the one additive term."""
        named, groups = list[str](), self.groups(tasks)
        for name in chain(*groups):
            check_known("order", "task", name, tasks, PreferenceError)
            if name in named:
                raise PreferenceError(f"order: {name!r} is named twice")
            named.append(name)
        if not named:
            raise PreferenceError(f"order: must name at least one task (valid: {', '.join(tasks)})")
        return [OrderRate(tuple(tuple(map(tasks.index, group)) for group in groups))]


@dataclass(frozen=True)
class WeightedSum:
    """mu = sum_i w_i c_i, or over violation costs sum_i w_i v_i.

    Attributes:
        weights: weights >= 0 by task; 0 for tasks not named.
        over: `cost` or `violation`.
    """

    weights: Annotated[Mapping[str, Number], WEIGHTS]
    over: str = "cost"

    def terms(self, tasks: Sequence[str], rules: Sequence[str] = ()) -> list[Term | Fraction]:
        """Return the one additive term."""
        weighted = _weighted(_amounts(tasks, rules, self.over), self.weights, 0)
        return _terms(_total(weighted), len(tasks) + len(rules))


@dataclass(frozen=True)
class Max:
    """mu = max_i w_i c_i, or over violation costs max_i w_i v_i.

    Attributes:
        weights: weights >= 0 by task; 1 for tasks not named.
        over: `cost` or `violation`.
    """

    weights: Annotated[Mapping[str, Number] | None, WEIGHTS] = None
    over: str = "cost"

    def terms(self, tasks: Sequence[str], rules: Sequence[str] = ()) -> list[Term | Fraction]:
        """Return the one convex term, or over violation costs a componentwise one."""
        weighted = _weighted(_amounts(tasks, rules, self.over), self.weights or {}, 1)
        return _terms(Operation("max", tuple(weighted)), len(tasks) + len(rules))


@dataclass(frozen=True)
class Due:
    """A deadline: the cost `by` which a task should be satisfied, and the weight of each unit of tardiness."""

    by: Number
    weight: Number = 1


@dataclass(frozen=True)
class Deadline:
    """Weighted tardiness: mu = sum_i weight_i max(0, c_i - by_i), or the same over violation costs.

    Attributes:
        deadlines: deadlines by task; tasks not named have none.
        over: `cost` or `violation`.
    """

    deadlines: Mapping[
        str, Annotated[Due, Form("a table such as { by = 20, weight = 1 }", "a deadline such as Due(by=20, weight=1)")]
    ]
    over: str = "cost"

    def terms(self, tasks: Sequence[str], rules: Sequence[str] = ()) -> list[Term | Fraction]:
        """Return a convex term for each deadline, or over violation costs a componentwise one."""
        amounts, tardiness = _amounts(tasks, rules, self.over), list[Tree]()
        for name, due in self.deadlines.items():
            check_known("deadlines", "task", name, amounts, PreferenceError)
            weight, by = (_weight(f"deadlines.{name}.{key}", getattr(due, key)) for key in ("weight", "by"))
            late = Operation("max", (Constant(Fraction(0)), Operation("-", (amounts[name], Constant(by)))))
            tardiness.append(Operation("*", (Constant(weight), late)))
        return _terms(_total(tardiness), len(tasks) + len(rules))


@dataclass(frozen=True)
class Expression:
    """mu as a formula over the tasks' costs: `+ - * / min max abs`, numbers and brackets.

    Attributes:
        expression: the formula; a task's name stands for its cost.
        contract: `additive`, `convex`, `componentwise` or `general`: the property that the search relies on; None to
            derive it. A declared contract is tested on random costs.
        over: `cost` or `violation`.
    """

    expression: Annotated[str, Form('text, such as "TASK1 + 2 * TASK2"')]
    contract: str | None = None
    over: str = "cost"

    def terms(self, tasks: Sequence[str], rules: Sequence[str] = ()) -> list[Term | Fraction]:
        """Return the expression as additive and convex terms if it is a sum of such, else as one term."""
        amounts = _amounts(tasks, rules, self.over)
        tree = parse(self.expression, amounts)
        nothing = [Fraction(0)] * len(amounts)
        outline, summands = shape(tree, list(amounts)), decompose(tree, len(tasks) + len(rules))
        shown = "componentwise" if outline.rising else "general"
        contract = _contract(self.contract) or shown
        whole = OpaqueTerm(tree, contract, claimed=contract not in (shown, "general"))
        if (outline.rising and outline.low >= 0) or (summands is not None and evaluate(tree, nothing, nothing) >= 0):
            # It never falls, so that its value at large costs shows whether it can be too large.
            large = [SPAN[1]] * len(amounts)
            value_at((large, large), whole, list(amounts), "expression")
        else:
            check_never_falls(whole, (*tasks, *rules), "expression")
        if whole.claimed:
            check_contract(whole, (*tasks, *rules), "contract")
        return [whole] if summands is None or self.contract == "general" else summands


@dataclass(frozen=True)
class Function:
    """mu as a Python function.

    Attributes:
        function: (costs, violations) -> mu; both are float64 arrays in the user's units, of the tasks and then of the
            rules that may be broken, whose costs are 0.
        contract: as in `Expression`; it is tested on random costs.
    """

    function: Annotated[Callable[[Any, Any], float], Form("", "a function of (costs, violations)")]
    contract: str = "general"

    def terms(self, tasks: Sequence[str], rules: Sequence[str] = ()) -> list[Term | Fraction]:
        """Return the function as a term."""
        names, contract = (*tasks, *rules), _contract(self.contract) or "general"

        def call(*amounts: Any) -> float:
            values = np.array(amounts, dtype=float)
            return float(self.function(values[: len(names)], values[len(names) :]))

        costs: list[Tree] = [Variable(i) if i < len(tasks) else Constant(Fraction(0)) for i in range(len(names))]
        tree = Operation(call, (*costs, *(Variable(i, True) for i in range(len(names)))))
        whole = OpaqueTerm(tree, contract, claimed=True)
        check_never_falls(whole, names, "function")
        check_contract(whole, names, "contract")
        return [whole]


@dataclass(frozen=True)
class Sum:
    """mu = sum_k w_k mu_k.

    Attributes:
        parts: preferences and their weights >= 0.
    """

    parts: Annotated[
        tuple[tuple[Preference, Number], ...],
        Form("", "pairs of a preference and its weight, such as [(Order(), 1), (Max(), 2)]"),
    ]

    def terms(self, tasks: Sequence[str], rules: Sequence[str] = ()) -> list[Term | Fraction]:
        """Return the terms of all parts."""
        if not self.parts:
            raise PreferenceError("terms: a sum needs at least one")
        terms: list[Term | Fraction] = []
        for k, (part, number) in enumerate(self.parts):
            with prefixed(f"terms[{k}].", PreferenceError):
                weight = _weight("weight", number)
                for term in checked_terms(part.terms(tasks, *([rules] if rules else [])), len(tasks) + len(rules)):
                    scaled = partial(mul, weight)
                    terms.append(scaled(term) if isinstance(term, Fraction) else with_weights(term, scaled))
        return terms


def _amounts(tasks: Sequence[str], rules: Sequence[str], over: str) -> dict[str, Variable]:
    """Return the variables of a preference by name: costs of tasks, or violation costs of tasks and rules."""
    if over not in OVER:
        raise PreferenceError(f"over: {over!r} is unknown {choices(over, OVER)}")
    names = (*tasks, *rules) if over == "violation" else tasks
    return {name: Variable(i, over == "violation") for i, name in enumerate(names)}


def _weighted(amounts: Mapping[str, Variable], weights: Mapping[str, Number], default: int) -> list[Tree]:
    """Return each amount times its weight."""
    for name in weights:
        check_known("weights", "task", name, amounts, PreferenceError)
    factors = {name: _weight(f"weights.{name}", weights.get(name, default)) for name in amounts}
    return [Operation("*", (Constant(factors[name]), amount)) for name, amount in amounts.items()]


def _total(trees: Sequence[Tree]) -> Tree:
    nothing: Tree = Constant(Fraction(0))
    return reduce(lambda one, other: Operation("+", (one, other)), trees, nothing)


def _terms(tree: Tree, count: int) -> list[Term | Fraction]:
    """Return the terms of an expression over `count` tasks and rules that never falls as a cost grows."""
    return decompose(tree, count) or [OpaqueTerm(tree, "componentwise")]


def _weight(where: str, weight: Number) -> Fraction:
    with prefixed("", ModelError, new=PreferenceError):
        number = exact(weight, where)
    if number < 0:
        raise PreferenceError(f"{where}: must not be negative, but is {weight}")
    return number


def _contract(contract: str | None) -> str | None:
    if contract is not None and contract not in CONTRACTS:
        raise PreferenceError(f"contract: {contract!r} is unknown {choices(contract, CONTRACTS)}")
    return contract
