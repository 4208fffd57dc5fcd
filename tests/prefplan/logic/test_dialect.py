"""Formulas in the syntax of Spot, Owl, SPIN and LTLf2DFA, against the definitions of their operators."""

from __future__ import annotations

import random

import judge
import pytest
from judge.dialect import co_safe, core, draw, spelled

from prefplan import FormulaError, automaton, parse
from prefplan.logic.good_prefix import is_satisfied
from prefplan.logic.mtbdd import same
from prefplan.logic.normal_form import parse_rule

Label = frozenset[str]


def word(rng: random.Random) -> tuple[list[Label], list[Label]]:
    """Return the labels of an infinite word: a stem, and a loop."""
    labels = [frozenset(name for name in "ab" if rng.random() < 0.5) for _ in range(7)]
    length = rng.randint(1, 4)
    return labels[:-length], labels[-length:]


def reaches(dfa: judge.Formula, stem: list[Label], loop: list[Label]) -> bool:
    """Return whether an automaton accepts some prefix of stem loop loop ..."""
    state = 0
    for label in [*stem, *loop * (dfa.size + 1)]:
        state = dfa.step(state, label)
    return state == dfa.accepting


def test_formulas_in_all_spellings_mean_what_their_operators_are_defined_to() -> None:
    read = refused = 0
    for seed in range(600):
        rng = random.Random(f"dialect {seed}")
        formula = draw(rng, "ab", rng.choice((2, 3, 3, 4)))
        text = spelled(formula, rng)
        if not co_safe(formula):
            with pytest.raises(FormulaError, match="not co-safe"):
                parse(text)
            refused += 1
            continue
        tree, meaning, read = parse(text), core(formula), read + 1
        assert parse(str(tree)) == tree, text
        dfa = automaton(tree)
        for _ in range(8):
            stem, loop = word(rng)
            assert reaches(dfa, stem, loop) == judge.holds(meaning, stem, loop), (text, stem, loop)
            prefix = [*stem, *loop][: rng.randint(1, 7)]
            state = 0
            for label in prefix:
                state = dfa.step(state, label)
            assert is_satisfied(tree, prefix) == (state == dfa.accepting), (text, prefix)
    assert min(read, refused) > 100


def test_a_rule_is_broken_by_the_words_that_do_not_satisfy_it() -> None:
    rules = 0
    for seed in range(300):
        rng = random.Random(f"rule {seed}")
        formula = draw(rng, "ab", 3)
        if not co_safe(("not", formula)):
            continue
        rules += 1
        broken = automaton(parse_rule(spelled(formula, rng)))
        for _ in range(5):
            stem, loop = word(rng)
            assert reaches(broken, stem, loop) != judge.holds(core(formula), stem, loop), (formula, stem, loop)
    assert rules > 50


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("Fa & Xb", "F a & X b"),
        ("GF a | b", None),
        ("XXFa", "X X F a"),
        ("XF(a)", "X F a"),
        ("Ftrue & a", "F true & a"),
        ("a U b W true", "true"),
        ("F 'Goal' & X'a'", 'F "Goal" & X a'),
        ("tt & !ff & 1", "true & !false & true"),
        ("a -> b <-> c", "a -> (b <-> c)"),
        ("a ^ b | c & !d", "(a ^ b) | (c & !d)"),
        ("a U b R[0,2] c", "a U (b R[0,2] c)"),
        ("X[0] a", "a"),
        ("X[!] a", "X a"),
        ("F[2,] a", "X[2] F a"),
        ("!(a U[2,3] true)", "!a | X !a"),
        ("!(a U[1,] true)", "!a"),
        ("true R[2,3] b", "true"),
        ("true R[0,3] b", "b"),
        ("a R[2,] false", "F[0,1] a"),
        ("G[2,3] false", "false"),
    ],
)
def test_spellings(text: str, meaning: str | None) -> None:
    if meaning is None:
        with pytest.raises(FormulaError, match="'GF a' must hold for ever"):
            parse(text)
    else:
        ours, theirs = automaton(text), automaton(meaning)
        assert ours.size == theirs.size and all(map(same, ours.transitions, theirs.transitions))
        assert ours.accepting == theirs.accepting


def test_a_name_that_is_known_is_not_taken_for_operators() -> None:
    known = ["a", "Fa", "Goal", "Fine"]
    assert parse("Fa & F a", propositions=known) == parse('"Fa" & F a')
    assert parse("XGoal & FFine", propositions=known) == parse('X "Goal" & F "Fine"')
    with pytest.raises(FormulaError, match="unknown proposition 'Fgoal'"):
        parse("Fgoal", propositions=known)
    with pytest.raises(FormulaError, match="write the rule 'GFa'; 'GFa' is read as 'G Fa'"):
        parse("GFa", propositions=known)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (
            "F a & G !b",
            "'G !b' must hold for ever, which no finite plan shows; write the task '!b U a' or the rule 'G !b'",
        ),
        ("!F b & F(a & c)", "; write the task '!b U (a & c)' or the rule '!F b'"),
        ("!<>(a & b)", "; write the rule '!<>(a & b)'"),
        ("G !(a & b)", "; write the rule 'G !(a & b)'"),
        ("G F a", "; write the task 'F a'"),
        ("a W b", "; write the task 'a U b' or the rule 'a W b'"),
        ("b & a R c", "; write the task 'b & a M c' or the rule 'a R c'"),
        ("F(a & G b)", "; write the task 'F(a & b)'"),
        ("F a & X c & G b", "; write the task 'F a & X c' or the rule 'G b'"),
        ("!(a U b)", "'a U b' is negated, and may be met by what holds for ever"),
        ("Goal", "'Goal' is read as 'G oal': put a name in quotes"),
    ],
)
def test_what_is_not_co_safe_is_refused_with_what_can_be_written_instead(text: str, why: str) -> None:
    with pytest.raises(FormulaError) as caught:
        parse(text)
    assert why in str(caught.value).split("\n")[0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("F[5] a", "'F' takes two bounds: F[0,5], at column 2"),
        ("X[1,2] a", "'X' takes one number: X[3], at column 2"),
        ("a W[0,2] b", "'W' takes no bounds (X F G U R do), at column 4"),
        ("a U[5,2] b", "the bounds [5,2] are in the wrong order, at column 4"),
        ("F[0,1001] a", "more than 1000 steps, at column 2"),
        ("F[0," + "9" * 5000 + "] a", "more than 1000 steps, at column 2"),
        ("5", "expected a formula, not '5', at column 1"),
        (" <-> ".join("F[0,1] a" for _ in range(30)), "more than 20000 parts without `<->` and `^`"),
    ],
)
def test_bounds_and_sizes(text: str, message: str) -> None:
    with pytest.raises(FormulaError) as caught:
        parse(text)
    assert str(caught.value).startswith(message)


def test_large_bounds_make_automata_of_as_many_states() -> None:
    assert automaton("F[0,400] a").size == 403
    assert is_satisfied(parse("a U[0,300] b"), [frozenset("a")] * 300 + [frozenset("b")])
    assert not is_satisfied(parse("a U[0,300] b"), [frozenset("a")] * 301 + [frozenset("b")])
