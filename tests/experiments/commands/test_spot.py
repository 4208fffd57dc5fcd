"""Minimal DFAs against Spot, another tool's LTL translator; skipped where its wheel cannot be imported.

Two minimal automata of the same language are isomorphic. So both agree on which words are good prefixes of a formula,
those that lead to the accepting state.
"""

from __future__ import annotations

import random

import judge
import pytest

from experiments.figures.diagrams.automaton_text import hoa
from prefplan.logic.dfa import automaton

spot = pytest.importorskip("spot", reason="the extra 'spot' is not installed", exc_type=ImportError)

NUMBER = 300
"""Number of random formulas."""


def random_formula(seed: int) -> str:
    rng = random.Random(f"spot {seed}")
    return judge.to_text(judge.random_formula(rng, "abc"[: rng.choice((2, 3, 3))], rng.choice((2, 3, 4))))


def test_printed_automata_are_equivalent_to_the_formula_and_as_small_as_spots() -> None:
    drawn = map(random_formula, range(NUMBER))
    for formula in (*drawn, "true", "false", "X(a | !a)", "F(a & F b & F c)", "(!a U b) & (!c U a)"):
        ours = spot.automaton(hoa(automaton(formula)))
        assert spot.are_equivalent(ours, spot.formula(formula)), formula
        assert spot.is_deterministic(ours) and spot.is_complete(ours) and spot.is_terminal_automaton(ours), formula
        theirs = spot.complete(spot.minimize_wdba(spot.translate(formula)))
        assert ours.num_states() == theirs.num_states(), formula
