"""Temporal tasks that may be relaxed, and rules: what a problem's formulas are, and the automata of them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field, replace

from prefplan.errors import FormulaError, PrefplanError, check_known, prefixed
from prefplan.exact_costs import Number, exact
from prefplan.logic.dfa import Automaton, automaton
from prefplan.logic.formula import Formula, is_temporal
from prefplan.logic.normal_form import parse, parse_rule
from prefplan.names import check_names


@dataclass(frozen=True)
class Relaxation:
    """A reading that may be bought: `assume` counts as true wherever `when` holds and it is false, for `cost`.

    Attributes:
        assume: a proposition.
        when: a formula without temporal operators.
        cost: price of each such reading; it counts towards the task's violation cost, not the total cost.
    """

    assume: str
    when: str
    cost: Number

    @property
    def condition(self) -> Formula:
        """The syntax tree of `when`."""
        return parse(self.when, temporal=False)


@dataclass(frozen=True)
class Task:
    """A temporal task: a co-safe formula (Definition 2), and how it may be relaxed (Remarks 1 to 6).

    Attributes:
        name: what costs and preferences call it.
        formula: the task.
        relax: readings that may be bought.
        skip: price of dropping the task before the first action; None if it may not be dropped.
        known: the propositions that there are, to tell `Fa` from `F a`; None until the task is part of a problem.
    """

    name: str
    formula: str
    relax: tuple[Relaxation, ...] = ()
    skip: Number | None = None
    known: frozenset[str] | None = field(default=None, repr=False, compare=False, kw_only=True, metadata={"key": None})

    @property
    def tree(self) -> Formula:
        """The formula's syntax tree.

        Raises:
            FormulaError: it is no co-safe formula over the known propositions.
        """
        return parse(self.formula, propositions=self.known)


@dataclass(frozen=True)
class Rule:
    """A safety formula, which no plan breaks; or only once, for a price.

    Attributes:
        name: what messages and preferences over violations call it.
        formula: the rule.
        skip: price of breaking it, after which it is gone; None if it may not be broken.
        known: as of a task.
    """

    name: str
    formula: str
    skip: Number | None = None
    known: frozenset[str] | None = field(default=None, repr=False, compare=False, kw_only=True, metadata={"key": None})

    @property
    def broken(self) -> Formula:
        """What its bad prefixes satisfy, as a syntax tree.

        Raises:
            FormulaError: it is no safety formula over the known propositions.
        """
        return parse_rule(self.formula, propositions=self.known)

    @property
    def monitor(self) -> Automaton:
        """The DFA of its bad prefixes.

        Raises:
            FormulaError: as for `broken`.
        """
        return automaton(self.broken, text=self.formula)


class Possible(Rule):
    """That a co-safe formula can still be satisfied, if not by the plan: its bad prefixes are those of the formula."""

    @property
    def monitor(self) -> Automaton:
        """The DFA of its bad prefixes: it ends where that of the formula is dead."""
        dfa = automaton(parse(self.formula, propositions=self.known), text=self.formula)
        return replace(dfa, accepting=dfa.dead, dead=dfa.accepting)


def task_automaton(task: Task, where: str, taken: Collection[str]) -> Automaton:
    """Return the automaton of a task, once its name and what it may be relaxed by are checked.

    Args:
        task: the task.
        where: its key, for messages.
        taken: names that it may not have.

    Raises:
        PrefplanError: its name, formula or a relaxation makes no sense; the message begins with the key.
    """
    _check_name(f"{where}.name", task.name, taken)
    with prefixed(f"{where}.formula: ", FormulaError):
        dfa = automaton(task.tree, text=task.formula)
    known = sorted(task.known or ())
    for k, relaxation in enumerate(task.relax):
        at = f"{where}.relax[{k}]"
        check_known(f"{at}.assume", "proposition", relaxation.assume, known, PrefplanError)
        with prefixed(f"{at}.when: ", FormulaError):
            condition = parse(relaxation.when, propositions=known, temporal=False)
            if is_temporal(condition):
                raise FormulaError(f"'{relaxation.when}' has a temporal operator")
        _check_price(f"{at}.cost", relaxation.cost)
    _check_price(f"{where}.skip", task.skip)
    return dfa


def rule_monitor(rule: Rule, where: str, taken: Collection[str]) -> Automaton:
    """Return the automaton of a rule's bad prefixes; arguments and errors as of `task_automaton`."""
    _check_name(f"{where}.name", rule.name, taken)
    _check_price(f"{where}.skip", rule.skip)
    with prefixed(f"{where}.formula: ", FormulaError):
        return rule.monitor


def _check_name(where: str, name: str, taken: Collection[str]) -> None:
    check_names([name], where=where)
    if name in ("min", "max", "abs"):
        raise PrefplanError(f"{where}: {name!r} is a reserved word (min max abs)")
    if name in taken:
        raise PrefplanError(f"{where}: {name!r} is used twice")


def _check_price(where: str, price: Number | None) -> None:
    if price is not None and exact(price, where) < 0:
        raise PrefplanError(f"{where}: negative cost {price}")
