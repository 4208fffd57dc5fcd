"""Formulas on traces, against hand-computed cases and the judge's own semantics."""

from __future__ import annotations

import random

import judge
import pytest
from judge.semantics import satisfaction_index
from judge.syntax import random_formula, to_text

from prefplan.logic.good_prefix import Label, is_satisfied, satisfied_at
from prefplan.logic.normal_form import parse


def labels(*words: str) -> list[Label]:
    """Write a trace of one-letter propositions: `labels("a", "", "bc")`."""
    return [frozenset(word) for word in words]


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
    """By the planner and by the judge."""
    assert satisfied_at(parse(text), trace) == index
    assert satisfaction_index(judge.parse(text), trace) == index


def random_trace(rng: random.Random, propositions: str) -> list[Label]:
    density = rng.choice((0.2, 0.5, 0.8))
    length = rng.randint(0, 8)
    return [frozenset(p for p in propositions if rng.random() < density) for _ in range(length)]


def test_an_empty_trace_satisfies_what_always_holds() -> None:
    assert is_satisfied(parse("X (a | !a)"), [])
    assert not is_satisfied(parse("F a"), [])
    assert satisfied_at(parse("true"), []) is None


def test_traces_and_the_judge_agree(rng: random.Random) -> None:
    found = {True: 0, False: 0}
    for _ in range(150):
        formula = random_formula(rng, "abc", rng.randint(1, 4))
        tree = parse(to_text(formula))
        for _ in range(4):
            trace = random_trace(rng, "abc")
            position = satisfied_at(tree, trace)
            assert position == satisfaction_index(formula, trace), (str(tree), trace)
            found[position is None] += 1
    assert min(found.values()) > 40


def test_long_traces_of_a_task_with_many_goals_are_judged() -> None:
    names = [f"p{i}" for i in range(12)]
    tree = parse(" & ".join(f"(!bad U {name})" for name in names))
    trace = [frozenset[str]()] * 400 + [frozenset({name}) for name in names]
    assert satisfied_at(tree, trace) == len(trace) - 1
    assert satisfied_at(tree, [*trace[:400], frozenset({"bad"}), *trace[400:]]) is None


def test_traces_of_nested_counting_operators_are_judged_soon() -> None:
    trace = [frozenset[str]()] * 50 + labels("a", *[""] * 30, "b") + [frozenset[str]()] * 300
    assert satisfied_at(parse("F[0,50] (a & F[0,50] b)"), trace) == 81
    assert satisfied_at(parse("F[0,50] (a & F[0,29] b)"), trace) is None
