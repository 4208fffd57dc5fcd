"""The judge of formulas against hand-computed cases and the definition of LTL."""

from __future__ import annotations

import random
from itertools import product

import pytest
from judge import holds, parse, random_formula, random_text, satisfaction_index, to_text
from judge.semantics import Label, monitor, powerset
from judge.syntax import bracketed, is_co_safe


def labels(*words: str) -> list[Label]:
    """Write a trace of one-letter propositions: `labels("a", "", "bc")`."""
    return [frozenset(word) for word in words]


@pytest.mark.parametrize("text", ["", "a b", "(a", "a)", "a &", "U a", "a # b", "G a"])
def test_what_is_no_formula_is_not_read(text: str) -> None:
    with pytest.raises(ValueError):
        parse(text)


def test_every_way_of_writing_a_formula_reads_back_the_same(rng: random.Random) -> None:
    for _ in range(500):
        formula = random_formula(rng, ["a", "b", "c_1"], rng.randrange(5))
        assert is_co_safe(formula)
        assert parse(to_text(formula)) == parse(bracketed(formula)) == parse(random_text(formula, rng)) == formula


@pytest.mark.parametrize(
    ("text", "trace", "index"),
    [
        ("true", labels(""), 0),
        ("false", labels("", "", ""), None),
        ("a | !a", labels(""), 0),
        ("X(a | !a)", labels(""), 0),
        ("F a | F !a", labels(""), 0),
        ("(a U b) | (!a U b)", labels("a", "a", "b"), 2),
        ("(a U b) | (!a U b)", labels("a", "", "b"), None),
        ("(a U b) | F !b", labels("a"), 0),
        ("(a U b) | F !b", labels("b"), 0),
        ("F a", labels("b", "", "a", "a"), 2),
        ("X a", labels("a", "a"), 1),
        ("X X b", labels("b", "b", ""), None),
        ("F(a & X b)", labels("a", "a", "b"), 2),
        ("F(a & F b)", labels("b", "a", "b"), 2),
        ("F(a & F b)", labels("b", "ab"), 1),
        ("!a U b", labels("", "a", "b"), None),
        ("!a U b", labels("", "ab"), 1),
        ("a -> F b", labels(""), 0),
        ("a -> F b", labels("a", "", "b"), 2),
        ("F F a & (b U true)", labels("", "a"), 1),
    ],
)
def test_a_task_is_satisfied_at_the_first_good_prefix(text: str, trace: list[Label], index: int | None) -> None:
    assert satisfaction_index(parse(text), trace) == index


def test_good_prefixes_are_those_no_continuation_can_spoil(rng: random.Random) -> None:
    for _ in range(250):
        atoms = ["a", "b"]
        formula = random_formula(rng, atoms, rng.randint(1, 4))
        letters = powerset(atoms)
        judge = monitor(formula)
        state, trace = judge.start, []
        for _ in range(4):
            trace.append(rng.choice(letters))
            state = judge.step(state, trace[-1])
            spoiler = judge.violation(state)
            if spoiler is not None:
                assert not holds(formula, [*trace, *spoiler[0]], spoiler[1])
            else:
                for stem, loop in product(letters, letters):
                    assert holds(formula, [*trace, stem], [loop])


def test_formulas_that_are_not_co_safe_have_no_monitor() -> None:
    for text in ("!(a U b)", "F a -> b", "!X a"):
        with pytest.raises(ValueError, match="co-safe"):
            monitor(parse(text))
