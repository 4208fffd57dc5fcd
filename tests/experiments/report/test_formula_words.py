"""Formulas told in words."""

import pytest

from experiments.report.formula_words import words_of


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        ("F tray", "eventually tray"),
        ("!pizza U cheese", "no pizza until cheese"),
        ("F (grocer & F p2)", "eventually (grocer and eventually p2)"),
        ("F ((a & b) & F c)", "eventually (a and b and eventually c)"),
        ("(a U b) & (c | !d)", "(a until b) and (c or no d)"),
        ("a U b U c", "a until (b until c)"),
        ("X X (a & b)", "one action later one action later (a and b)"),
        ("(lid -> open) U full", "(no lid or open) until full"),
        ("true | false", "anything or the impossible"),
    ],
)
def test_a_formula_is_told_so_that_its_parts_stay_together(formula: str, words: str) -> None:
    assert words_of(formula) == words
