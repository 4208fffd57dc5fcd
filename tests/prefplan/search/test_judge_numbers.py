"""Problems of every kind of preference and style of numbers, held against the judges."""

from __future__ import annotations

import pytest
from judge.fuzz import AGREES, judged

PROBLEMS = 25


@pytest.mark.slow
@pytest.mark.parametrize("block", range(16))
def test_fronts_bounds_and_plans_are_those_of_the_judges(block: int) -> None:
    outcomes = list(judged(iter(range(PROBLEMS * block, PROBLEMS * (block + 1)))))
    assert [(number, name, wrong) for number, name, outcome, wrong in outcomes if outcome != AGREES] == []
