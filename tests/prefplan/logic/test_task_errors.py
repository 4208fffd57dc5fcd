"""Invalid relaxations, prices of skipping and numbers of tasks: each is refused with a message."""

from __future__ import annotations

import re
from typing import Any

import pytest
from small_models import NAMES, build

from prefplan import (
    Expression,
    FormulaError,
    Max,
    Order,
    PrefplanError,
    Problem,
    Relaxation,
    Sum,
    Task,
    TransitionSystem,
    WeightedSum,
)
from prefplan.preferences.kinds import Preference

VIOLATION = WeightedSum({name: 1 for name in NAMES}, over="violation")


@pytest.mark.parametrize(
    ("relaxation", "error", "message"),
    [
        (("z", "p", 1), PrefplanError, "assume: unknown proposition 'z' (valid: p, q, r)"),
        (("r", "pp", 1), FormulaError, "when: unknown proposition 'pp' (did you mean 'p'?), at column 1"),
        (("r", "F p", 1), FormulaError, "when: 'F p' has a temporal operator"),
        (("r", "q | p U q", 1), FormulaError, "when: 'q | p U q' has a temporal operator"),
        (("r", "p &", 1), FormulaError, "when: expected a formula, but the formula ends, at column 4"),
        (("r", "p", -1), PrefplanError, "cost: negative cost -1"),
    ],
)
def test_a_relaxation_that_makes_no_sense_names_the_key(
    relaxation: tuple[str, str, int], error: type[PrefplanError], message: str
) -> None:
    good = Relaxation("r", "p", 1)
    with pytest.raises(error, match="^" + re.escape(f"tasks[0].relax[1].{message}")):
        build(VIOLATION, relax=(good, Relaxation(*relaxation)))


def test_a_negative_price_of_skipping_is_refused() -> None:
    with pytest.raises(PrefplanError, match=r"^tasks\[0\].skip: negative cost -2$"):
        build(VIOLATION, skip=-2)


@pytest.mark.parametrize(
    "preference", [Order(), Max(), Expression("phi1"), Sum(((Order(), 1), (WeightedSum(dict.fromkeys(NAMES, 1)), 1)))]
)
@pytest.mark.parametrize(
    ("task", "key"), [({"relax": (Relaxation("r", "p", 1),)}, "relax"), ({"skip": 3}, "skip")], ids=["relax", "skip"]
)
def test_what_no_term_weighs_may_not_be_relaxed(preference: Preference, task: dict[str, Any], key: str) -> None:
    with pytest.raises(PrefplanError) as caught:
        build(preference, **task)
    assert str(caught.value) == (
        f'tasks[0].{key}: no term of the preference depends on this price; add a term with over = "violation"'
    )


@pytest.mark.parametrize(
    ("tasks", "message"),
    [
        ([], "tasks: a problem needs at least one task"),
        ([Task(f"t{k}", "F p") for k in range(21)], "tasks: 21 are more than the 20 that the search can take"),
        ([Task("a", "F p"), Task("a", "F p")], "tasks[1].name: 'a' is used twice"),
        ([Task("min", "F p")], "tasks[0].name: 'min' is a reserved word (min max abs)"),
        ([Task("U", "F p")], "tasks[0].name: 'U' is a reserved word (F G M R U W X and false not or true)"),
        ([Task("a", "F p"), Task("b", "F q")], "tasks[1].formula: unknown proposition 'q' (valid: p), at column 3"),
    ],
)
def test_a_problem_made_in_python_has_the_same_errors(tasks: list[Task], message: str) -> None:
    system = TransitionSystem.from_transitions([], start="s", propositions=["p"])
    with pytest.raises(PrefplanError) as caught:
        Problem(system, tasks, Order())
    assert str(caught.value).split("\n")[0] == message
