"""Minimal DFAs against Spot, another tool's LTL translator; skipped where its wheel cannot be imported.

Of a co-safe formula f, Spot's deterministic monitor of !f reads exactly the words that are no good prefix of f: each of
its states can go on. So a word is a good prefix of f if and only if the monitor gets stuck on it.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from itertools import combinations
from typing import Any

import judge
import pytest

from experiments.figures.diagrams.automaton_text import hoa
from prefplan import Automaton
from prefplan.logic.dfa import automaton

spot = pytest.importorskip("spot", reason="the extra 'spot' is not installed", exc_type=ImportError)
buddy = pytest.importorskip("buddy", reason="the extra 'spot' is not installed", exc_type=ImportError)

NUMBER = 300
"""Formulas drawn."""


def formulas() -> Iterator[str]:
    for seed in range(NUMBER):
        rng = random.Random(f"spot {seed}")
        yield judge.to_text(judge.random_formula(rng, "abc"[: rng.choice((2, 3, 3))], rng.choice((2, 3, 4))))
    yield from ("true", "false", "X(a | !a)", "F(a & F b & F c)", "(!a U b) & (!c U a)")


def letter(monitor: Any, label: frozenset[str], names: tuple[str, ...]) -> Any:
    """Return a label as a BDD over the propositions of one of Spot's automata."""
    result = buddy.bddtrue
    for name in names:
        variable = monitor.register_ap(name)
        result &= buddy.bdd_ithvar(variable) if name in label else buddy.bdd_nithvar(variable)
    return result


def pairs(dfa: Automaton, monitor: Any) -> dict[tuple[int, int | None], list[str]]:
    """Return all pairs of states that some word leads both to, with such a word; None where the monitor is stuck."""
    names = dfa.propositions
    labels = [frozenset(subset) for size in range(len(names) + 1) for subset in combinations(names, size)]
    read = {label: letter(monitor, label, names) for label in labels}
    start = monitor.get_init_state_number() if monitor.num_edges() else None
    found: dict[tuple[int, int | None], list[str]] = {(0, start): []}
    queue = list(found)
    for state, other in queue:
        for label in labels:
            ends = (
                [] if other is None else [e.dst for e in monitor.out(other) if buddy.bdd_implies(read[label], e.cond)]
            )
            assert len(ends) <= 1
            after = (dfa.step(state, label), ends[0] if ends else None)
            if after not in found:
                found[after] = [*found[state, other], "".join(sorted(label)) or "-"]
                queue.append(after)
    return found


def test_good_prefixes_are_those_of_spots_monitor_of_the_negation() -> None:
    for formula in formulas():
        dfa = automaton(formula)
        monitor = spot.translate(spot.formula.Not(spot.formula(formula)), "monitor", "deterministic")
        for (state, other), word in pairs(dfa, monitor).items():
            assert (state == dfa.accepting) == (other is None), (formula, word)


def test_printed_automata_are_equivalent_to_the_formula_and_as_small_as_spots() -> None:
    for formula in formulas():
        ours = spot.automaton(hoa(automaton(formula)))
        assert spot.are_equivalent(ours, spot.formula(formula)), formula
        assert spot.is_deterministic(ours) and spot.is_complete(ours) and spot.is_terminal_automaton(ours), formula
        theirs = spot.complete(spot.minimize_wdba(spot.translate(formula)))
        assert ours.num_states() == theirs.num_states(), formula
