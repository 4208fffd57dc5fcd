"""Formulas on traces, against the judge's own semantics."""

from __future__ import annotations

import random

from judge.semantics import satisfaction_index
from judge.syntax import random_formula, to_text

from prefplan.logic.good_prefix import Label, is_satisfied, satisfied_at
from prefplan.logic.normal_form import parse


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
