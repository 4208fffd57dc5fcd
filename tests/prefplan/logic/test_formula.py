"""Parsing scLTL: precedence, refused formulas, and the column that a message points at."""

from __future__ import annotations

import random

import judge
import pytest
from judge.semantics import holds_now, powerset
from judge.syntax import random_boolean

from prefplan import FormulaError, parse
from prefplan.logic.formula import holds, is_temporal, propositions_of


def caret_column(error: FormulaError) -> int:
    """Return the column, counted from 1, that the caret of a message stands under."""
    _, formula, pointer = str(error).split("\n")
    assert formula.startswith("    ") and pointer.strip() == "^"
    return len(pointer) - len("    ")


@pytest.mark.parametrize(
    ("short", "full"),
    [
        ("!a & b", "(!a) & b"),
        ("X a & b", "(X a) & b"),
        ("F X !a", "F (X (!a))"),
        ("a U b U c", "a U (b U c)"),
        ("a | b & c", "a | (b & c)"),
        ("a -> b -> c", "a -> (b -> c)"),
        ("a -> b", "!a | b"),
        ("F(a&F b)", "F ( a & F ( b ) )"),
        ("F a", "true U a"),
        ("a\n\tU\n\tb", "a U b"),
    ],
)
def test_precedence_and_associativity(short: str, full: str) -> None:
    assert parse(short) == parse(full)


def test_needless_brackets_and_spaces_do_not_matter() -> None:
    for seed in range(300):
        rng = random.Random(seed)
        formula = judge.random_formula(rng, ["a", "b", "_c3"], 4)
        expected = parse(judge.bracketed(formula))
        for text in (judge.to_text(formula), judge.random_text(formula, rng)):
            assert parse(text) == expected, text


@pytest.mark.parametrize(
    ("text", "part", "column"),
    [
        ("G a", "'G a' must hold for ever", 1),
        ("a U G b", "'G b' must hold for ever", 5),
        ("a R b", "'a R b' may be met by what holds for ever", 1),
        ("F(a W (b | c))", "'a W (b | c)' may be met by what holds for ever", 3),
        ("!(a U b)", "'a U b' is negated, and may be met by what holds for ever", 3),
        ("!!!(a & F b)", "'F b' is negated, so that it must never hold", 9),
        ("F a -> b", "'F a' is negated, so that it must never hold", 1),
        ("a -> X F b -> c", "'F b' is negated, so that it must never hold", 8),
    ],
)
def test_a_part_that_is_not_co_safe_is_named(text: str, part: str, column: int) -> None:
    with pytest.raises(FormulaError) as caught:
        parse(text)
    assert str(caught.value).startswith(f"not co-safe: {part}, which no finite plan shows")
    assert caret_column(caught.value) == column


@pytest.mark.parametrize(
    "text", ["!(a & b -> !c) U d", "!!a", "(a -> b) -> F c", "!true | X false", "!(a | (b -> c)) & F d"]
)
def test_negation_and_premises_without_temporal_operators_are_co_safe(text: str) -> None:
    assert is_temporal(parse(text)) == any(operator in text for operator in "XFU")


@pytest.mark.parametrize(
    ("text", "message", "column"),
    [
        ("(a", "'(' is never closed", 1),
        ("F(a & F(b)", "'(' is never closed", 2),
        ("a)", "')' closes no bracket", 2),
        ("(&", "expected a formula, not '&'", 2),
        ("a b", "expected an operator, not 'b'", 3),
        ("a & ", "expected a formula, but the formula ends", 4),
        ("(a &", "expected a formula, but the formula ends (the '(' at column 1 is never closed)", 5),
        ("", "expected a formula, but the formula ends", 1),
        ("a & & b", "expected a formula, not '&'", 5),
        ("a $ b", "'$' means nothing in a formula", 3),
        ("<a", "'<' means nothing in a formula", 1),
    ],
)
def test_a_syntax_error_points_at_its_column(text: str, message: str, column: int) -> None:
    with pytest.raises(FormulaError) as caught:
        parse(text)
    assert str(caught.value).startswith(f"{message}, at column {column}\n")
    assert caret_column(caught.value) == column


@pytest.mark.parametrize(
    ("text", "hint", "column"),
    [
        ("F chese", "unknown proposition 'chese' (did you mean 'cheese'?)", 3),
        ("pizza U Pizza", "unknown proposition 'Pizza' (did you mean 'pizza'?)", 9),
        ("pizza & zzz", "unknown proposition 'zzz' (valid: cheese, pizza)", 9),
    ],
)
def test_an_unknown_proposition_comes_with_the_nearest_known(text: str, hint: str, column: int) -> None:
    with pytest.raises(FormulaError) as caught:
        parse(text, propositions=["pizza", "cheese"])
    assert str(caught.value).startswith(f"{hint}, at column {column}\n")


def test_an_unknown_proposition_where_none_is_known() -> None:
    with pytest.raises(FormulaError, match=r"unknown proposition 'a' \(there are none: .*`labels` .*`regions`"):
        parse("F a", propositions=[])


def test_without_a_list_every_name_may_be_used() -> None:
    assert propositions_of(parse("F (F_a & X1 -> trueish) | _x U Under")) == {"F_a", "X1", "trueish", "_x", "Under"}


@pytest.mark.parametrize("opening", ["X ", "F ", "!", "a U ", "a -> ", "("])
def test_nesting_has_a_limit_instead_of_a_stack_overflow(opening: str) -> None:
    closing = ")" if opening == "(" else ""
    parse(opening * 100 + "a" + closing * 100)
    with pytest.raises(FormulaError, match="nested more than [0-9]+ deep"):
        parse(opening * 10_000 + "a")


@pytest.mark.parametrize("text", ["X" * 200 + "a", " ^ ".join(["a"] * 3000)])
def test_what_is_deep_without_brackets_has_a_limit_too(text: str) -> None:
    with pytest.raises(FormulaError, match="nested more than [0-9]+ deep"):
        parse(text)


def test_labels_decide_formulas_without_temporal_operators() -> None:
    for seed in range(100):
        drawn = random_boolean(random.Random(seed), ["a", "b", "c"], 3)
        formula = parse(judge.to_text(drawn))
        for label in powerset("abc"):
            expected = holds_now(drawn, label)
            assert holds(formula, label) == expected, (seed, label)
            assert holds(parse(f"!({judge.to_text(drawn)})"), label) == (not expected), (seed, label)
