"""Minimal DFAs of good prefixes (Definition 6), against hand-made cases and an independent tableau."""

from __future__ import annotations

import random
from collections.abc import Iterator
from itertools import combinations, product

import judge
import pytest
from judge.semantics import monitor, powerset

from prefplan import Automaton, FormulaError
from prefplan.errors import LimitError
from prefplan.limits import Limits
from prefplan.logic.dfa import automaton
from prefplan.logic.formula import TRUE
from prefplan.logic.weighted_dfa import WeightedAutomaton

Label = frozenset[str]
NONE: Label = frozenset()


def run(dfa: Automaton, *letters: str) -> int:
    """Return the state after a word; a letter is a string of one-letter propositions."""
    state = 0
    for letter in letters:
        state = dfa.step(state, frozenset(letter))
    return state


@pytest.mark.parametrize(
    ("formula", "states"),
    [
        ("true", 1),
        ("false", 1),
        ("a", 3),
        ("F a", 2),
        ("X a", 4),
        ("!a U b", 3),
        ("F(a | F b)", 2),
        ("F(a & X b)", 3),
        ("F(a & F(b & F c))", 4),
        ("F a & F b & F c", 8),
        ("X a | X !a", 1),
        ("F(a & !a)", 1),
        ("F(a & X b) | F(a & X !b)", 2),
        ("(a U b) & (b -> a U c) & false", 1),
        ("(!a U b) & (!c U a)", 4),
        ("F[0,20] (a & F[0,20] b)", 253),
    ],
)
def test_number_of_states(formula: str, states: int) -> None:
    assert automaton(formula).size == states


def test_nested_untils_have_a_state_a_name() -> None:
    names = "abcdefghijklmnopqrst"
    assert automaton(" U ".join(names)).size == len(names) + 1


def test_letters_are_never_listed() -> None:
    dfa = automaton("F(" + " | ".join(f"p{i}" for i in range(2000)) + ")")
    assert dfa.size == 2
    assert dfa.step(0, frozenset({"p59"})) == dfa.accepting
    assert WeightedAutomaton(dfa, (("p5", TRUE, 3), ("p1999", TRUE, 2))).readings(0, frozenset())[1].price == 2


def test_readings_with_fewer_relaxations_come_first() -> None:
    readings = WeightedAutomaton(automaton("F a & F b"), (("a", TRUE, 1), ("b", TRUE, 1))).readings(0, frozenset())
    assert [reading.relaxations for reading in readings] == [(), (0,), (1,), (0, 1)]


def test_limits_hold_while_an_automaton_is_built() -> None:
    with Limits(seconds=0), pytest.raises(LimitError, match="stopped by the time limit"):
        automaton("F[0,1000] F[0,1000] a")


def test_an_automaton_that_would_be_too_large_is_refused() -> None:
    with pytest.raises(FormulaError, match="needs an automaton of more than 20000 states"):
        automaton("F(a & " + "X " * 18 + "b)")


@pytest.mark.parametrize(
    ("text", "size"),
    [
        (" & ".join(["a"] * 2000), 3),
        (" | ".join(["F a"] * 900), 2),
        ("F(" * 9 + "a" + f"{' & b' * 90})" * 9, 2),
    ],
)
def test_a_long_formula_is_read_without_a_stack_overflow(text: str, size: int) -> None:
    assert automaton(text).size == size


Drawn = list[tuple[judge.Formula, Automaton]]
BLOCK = 20
"""Formulas checked by one test, to keep the number of tests small."""


@pytest.fixture(scope="module", params=range(0, 400, BLOCK))
def drawn(request: pytest.FixtureRequest) -> Drawn:
    """Random formulas over up to three propositions, and the automata made of their texts."""
    found = []
    for seed in range(request.param, request.param + BLOCK):
        rng = random.Random(seed)
        formula = judge.random_formula(rng, "abc"[: rng.choice((1, 2, 3))], rng.choice((2, 3, 4)))
        found.append((formula, automaton(judge.to_text(formula))))
    return found


def letters_of(dfa: Automaton) -> list[Label]:
    return powerset(dfa.propositions)


def test_the_language_is_that_of_the_tableau(drawn: Drawn) -> None:
    """Walk the automaton and the tableau of the negation side by side, over every letter."""
    for formula, dfa in drawn:
        tableau = monitor(formula)
        pairs = {(0, tableau.start)}
        pending = list(pairs)
        following: dict[int, set[int]] = {}
        while pending:
            state, progress = pending.pop()
            assert (state == dfa.accepting) == tableau.satisfied(progress), dfa.text
            for letter in letters_of(dfa):
                pair = (dfa.step(state, letter), tableau.step(progress, letter))
                following.setdefault(progress, set()).add(pair[1])
                if pair not in pairs:
                    pairs.add(pair)
                    pending.append(pair)
        hopeful = {progress for progress in following if tableau.satisfied(progress)}
        while more := {progress for progress in following if following[progress] & hopeful} - hopeful:
            hopeful |= more
        for state, progress in pairs:
            assert (state == dfa.dead) == (progress not in hopeful), dfa.text


def test_no_two_states_are_equivalent_and_all_are_numbered_breadth_first(drawn: Drawn) -> None:
    """Pairwise table-filling: a pair is told apart by acceptance, or by a letter that leads to such a pair."""
    for _, dfa in drawn:
        letters = letters_of(dfa)
        table = [[dfa.step(state, letter) for letter in letters] for state in range(dfa.size)]
        pairs = set(combinations(range(dfa.size), 2))
        apart = {(p, q) for p, q in pairs if (p == dfa.accepting) != (q == dfa.accepting)}
        while more := {pair for pair in pairs - apart if leads_to(table, pair, apart)}:
            apart |= more
        assert apart == pairs, dfa.text
        assert list(breadth_first(table)) == list(range(dfa.size)), dfa.text


def leads_to(table: list[list[int]], pair: tuple[int, int], goal: set[tuple[int, int]]) -> bool:
    """Say whether some letter leads from a pair of states to one of the pairs given."""
    return any(tuple(sorted(ends)) in goal for ends in zip(table[pair[0]], table[pair[1]], strict=True))


def breadth_first(table: list[list[int]]) -> Iterator[int]:
    """Yield the reachable states by distance from 0, and those of equal distance by number."""
    layer, seen = [0], {0}
    while layer:
        yield from sorted(layer)
        layer = list({after for state in layer for after in table[state]} - seen)
        seen.update(layer)


def test_guards_partition_the_letters(drawn: Drawn) -> None:
    for _, dfa in drawn:
        for state, letter in product(range(dfa.size), letters_of(dfa)):
            ends = [end for guard, end in dfa.guards(state) if guard.items() <= {p: p in letter for p in "abc"}.items()]
            assert ends == [dfa.step(state, letter)], dfa.text
