"""Temporal tasks, which may be relaxed, and rules, with their automata."""

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, TypeVar

from prefplan.errors import FormulaError, PrefplanError, check_known, describe, prefixed
from prefplan.exact_costs import Number, exact
from prefplan.logic.dfa import Automaton, automaton
from prefplan.logic.formula import Formula, is_temporal
from prefplan.logic.normal_form import parse, parse_rule
from prefplan.text.forms import Form, check_fields
from prefplan.text.names import check_names

Text = Annotated[str, Form('text, such as "F p"')]


@dataclass(frozen=True)
class Relaxation:
    """A relaxation of a task: where `when` holds, `assume` may be read as true although it is false, for `cost`.

    Attributes:
        assume: a proposition.
        when: a formula without temporal operators.
        cost: price of each such reading; it is added to the task's violation cost, not to the total cost.
    """

    assume: str
    when: str
    cost: Number

    @property
    def condition(self) -> Formula:
        """The syntax tree of `when`."""
        return parse(self.when, temporal=False)


@dataclass(frozen=True)
class NamedFormula(ABC):
    """A formula with a name.

    Attributes:
        name: name by which costs, preferences and messages refer to it.
        formula: the formula, as text.
        propositions: the valid propositions, to tell `Fa` from `F a`; None until the formula is part of a problem.
    """

    name: str
    formula: Text
    propositions: frozenset[str] | None = field(
        default=None, repr=False, compare=False, kw_only=True, metadata={"key": None}
    )

    @property
    @abstractmethod
    def tree(self) -> Formula:
        """The tree of the formula whose good prefixes the automaton accepts; a FormulaError if it is not co-safe."""

    @property
    def automaton(self) -> Automaton:
        """The minimal DFA of the tree's good prefixes; a FormulaError if it would be too large."""
        return automaton(self.tree, text=self.formula)


@dataclass(frozen=True)
class Task(NamedFormula):
    """A temporal task: a co-safe formula (Definition 2), and how it may be relaxed (Remarks 1 to 6).

    Attributes:
        relax: relaxations that plans may use.
        skip: price of dropping the task before the first action; None if it may not be dropped.
        label: name to display; None for `name`.
    """

    relax: Annotated[
        tuple[Relaxation, ...],
        Form('a list such as [{ assume = "p", when = "q", cost = 1 }]', 'a tuple such as (Relaxation("p", "q", 1),)'),
    ] = ()
    skip: Number | None = None
    label: str | None = field(default=None, kw_only=True)

    @property
    def tree(self) -> Formula:
        """The formula's syntax tree; see `NamedFormula.tree`."""
        return parse(self.formula, propositions=self.propositions)


@dataclass(frozen=True)
class Rule(NamedFormula):
    """A safety formula that no plan breaks, or only for a price.

    Attributes:
        skip: price of breaking it, paid once, after which it no longer applies; None if it may not be broken.
    """

    skip: Number | None = None

    @property
    def tree(self) -> Formula:
        """The syntax tree of the negation, which bad prefixes satisfy; a FormulaError if this is no safety formula."""
        return parse_rule(self.formula, propositions=self.propositions)


class Possible(Rule):
    """The rule that a co-safe formula stays satisfiable: the bad prefixes of the formula are those of the rule."""

    @property
    def automaton(self) -> Automaton:
        """The DFA of its bad prefixes: that of the formula, with accepting and dead state exchanged."""
        dfa = Task(self.name, self.formula, propositions=self.propositions).automaton
        return replace(dfa, accepting=dfa.dead, dead=dfa.accepting)


Named = TypeVar("Named", Task, Rule)


def named_formulas(kind: type[Named], given: Mapping[str, str] | Iterable[Named], key: str) -> list[Named]:
    """Return tasks or rules, given as such or as formulas by name.

    Raises:
        PrefplanError: something else is given; the message begins with the key.
    """
    example = f'{kind.__name__}("NAME", "{"F p" if kind is Task else "G !p"}")'
    if isinstance(given, Mapping):
        given = [kind(name, formula) for name, formula in given.items()]
    if isinstance(given, (str, kind)) or not isinstance(given, Iterable):
        raise PrefplanError(
            f'{key}: must be formulas by name, such as {{"NAME": "F p"}}, or a list such as [{example}], '
            f"not {describe(given)}"
        )
    formulas = list(given)
    for i, one in enumerate(formulas):
        if not isinstance(one, kind):
            raise PrefplanError(f"{key}[{i}]: must be a {kind.__name__}, such as {example}, not {describe(one)}")
        check_fields(one, PrefplanError, f"{key}[{i}].")
    return formulas


def checked_automata(given: Sequence[Task | Rule], key: str, taken: Collection[str] = ()) -> tuple[Automaton, ...]:
    """Check the names, formulas and prices of tasks or rules, and return their automata.

    Raises:
        PrefplanError: a name is taken or invalid, or a formula or relaxation is; the message begins with the key.
    """
    automata, taken = [], {*taken}
    for i, one in enumerate(given):
        where = f"{key}[{i}]"
        check_names([one.name], where=f"{where}.name")
        if one.name in ("min", "max", "abs"):
            raise PrefplanError(f"{where}.name: {one.name!r} is a reserved word (min max abs)")
        if one.name in taken:
            raise PrefplanError(f"{where}.name: {one.name!r} is used twice")
        taken.add(one.name)
        with prefixed(f"{where}.formula: ", FormulaError):
            automata.append(one.automaton)
        if isinstance(one, Task):
            _check_relaxations(one, where)
        _check_price(f"{where}.skip", one.skip)
    return tuple(automata)


def _check_relaxations(task: Task, where: str) -> None:
    names = sorted(task.propositions or ())
    for k, relaxation in enumerate(task.relax):
        at = f"{where}.relax[{k}]"
        check_known(f"{at}.assume", "proposition", relaxation.assume, names, PrefplanError)
        with prefixed(f"{at}.when: ", FormulaError):
            if is_temporal(parse(relaxation.when, propositions=names, temporal=False)):
                raise FormulaError(f"'{relaxation.when}' has a temporal operator")
        _check_price(f"{at}.cost", relaxation.cost)


def _check_price(where: str, price: Number | None) -> None:
    if price is not None and exact(price, where) < 0:
        raise PrefplanError(f"{where}: negative cost {price}")
