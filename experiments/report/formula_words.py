"""A task's formula in words, for those who do not read temporal logic."""

from __future__ import annotations

from prefplan.logic.formula import TRUE, And, Formula, Literal, Next, Or, Truth, Until, parse


def words_of(text: str) -> str:
    """Return what a formula asks for, e.g. `eventually (grocer and eventually p2)`.

    It is told in positive normal form, so that `a -> b` reads as `no a or b`.

    Raises:
        FormulaError: the text is no co-safe formula.
    """
    return _words(parse(text))


def _words(formula: Formula) -> str:
    match formula:
        case Truth(value):
            return "anything" if value else "the impossible"
        case Literal(name, positive):
            return name if positive else f"no {name}"
        case And():
            return " and ".join(_part(member) for member in _members(formula, And))
        case Or():
            return " or ".join(_part(member) for member in _members(formula, Or))
        case Next(operand):
            return f"one action later {_part(operand)}"
        case Until(left, right):
            return f"eventually {_part(right)}" if left == TRUE else f"{_part(left)} until {_part(right)}"


def _part(formula: Formula) -> str:
    """Return a part of a formula, in brackets unless nothing beside it could be taken for a part of it."""
    alone = isinstance(formula, Truth | Literal | Next) or (isinstance(formula, Until) and formula.left == TRUE)
    return _words(formula) if alone else f"({_words(formula)})"


def _members(formula: Formula, kind: type[And] | type[Or]) -> list[Formula]:
    """Return what is joined by one connective, however it was bracketed."""
    if isinstance(formula, kind):
        return _members(formula.left, kind) + _members(formula.right, kind)
    return [formula]
