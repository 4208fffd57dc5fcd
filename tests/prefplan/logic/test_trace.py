"""Formulas judged on traces, against the automata and against the judge's own semantics."""

from __future__ import annotations

import random

import pytest
from judge.semantics import satisfaction_index
from judge.syntax import random_formula, to_text

from prefplan.logic.dfa import automaton
from prefplan.logic.formula import parse
from prefplan.logic.good_prefix import Label, is_satisfied, satisfied_at


def labels(text: str) -> list[Label]:
    """Return a trace written as `a - ab`: a label a word, `-` for none."""
    return [frozenset(word) - {"-"} for word in text.split()]


def random_trace(rng: random.Random, propositions: str) -> list[Label]:
    density = rng.choice((0.2, 0.5, 0.8))
    length = rng.randint(0, 8)
    return [frozenset(p for p in propositions if rng.random() < density) for _ in range(length)]


def by_automaton(text: str, trace: list[Label]) -> int | None:
    dfa, state = automaton(text), 0
    for k, label in enumerate(trace):
        state = dfa.step(state, label)
        if state == dfa.accepting:
            return k
    return None


@pytest.mark.parametrize(
    ("formula", "trace", "position"),
    [
        ("F a", "- b a b", 2),
        ("F a", "- b", None),
        ("!a U b", "- b", 1),
        ("!a U b", "- a b", None),
        ("F (a & X b)", "a - a b", 3),
        ("X X a", "- - a", 2),
        ("X (a | !a)", "-", 0),
        ("a | X (b | !b)", "-", 0),
        ("true", "-", 0),
        ("false", "a b", None),
        ("F (a | !a)", "-", 0),
        ("X a | X !a", "-", 0),
        ("X (a U b) | X (!b & (!a | X !b))", "-", 0),
        ("X (a U b) | X (!b & (a | X !b))", "-", None),
        ("(a U b) & F c", "a bc -", 1),
        ("a -> F b", "-", 0),
        ("a -> F b", "a - b", 2),
    ],
)
def test_the_first_good_prefix_is_found(formula: str, trace: str, position: int | None) -> None:
    assert satisfied_at(parse(formula), labels(trace)) == position


def test_an_empty_trace_satisfies_what_always_holds() -> None:
    assert is_satisfied(parse("X (a | !a)"), [])
    assert not is_satisfied(parse("F a"), [])
    assert satisfied_at(parse("true"), []) is None


@pytest.mark.parametrize("seed", range(5))
def test_traces_automata_and_the_judge_agree(seed: int) -> None:
    rng = random.Random(seed)
    found = {True: 0, False: 0}
    for _ in range(300):
        formula = random_formula(rng, "abc", rng.randint(1, 4))
        text = to_text(formula)
        tree = parse(text)
        for _ in range(4):
            trace = random_trace(rng, "abc")
            position = satisfied_at(tree, trace)
            assert position == satisfaction_index(formula, trace) == by_automaton(text, trace), (text, trace)
            found[position is None] += 1
    assert min(found.values()) > 100


def test_long_traces_of_a_task_with_many_goals_are_judged() -> None:
    names = [f"p{i}" for i in range(12)]
    tree = parse(" & ".join(f"(!bad U {name})" for name in names))
    trace = [frozenset[str]()] * 400 + [frozenset({name}) for name in names]
    assert satisfied_at(tree, trace) == len(trace) - 1
    assert satisfied_at(tree, [*trace[:400], frozenset({"bad"}), *trace[400:]]) is None
