"""Claims about rules that a plan or a run broke, judged by its trace."""

from __future__ import annotations

from fractions import Fraction

import pytest

from prefplan import Purchase, Rule, Task, WeightedSum
from prefplan.claims import Claims, judge

OVER, AROUND = ("carpet", "desk"), ("stones", "desk")
PAID = Purchase("clean", 1, None, 2, rule=True)


def refuted(places: tuple[str, ...], *purchases: Purchase, skip: int | None = 2) -> dict[str, str]:
    """Return the claims that do not hold of a way to the desk that should not lead over the carpet."""
    paid = sum(int(purchase.cost) for purchase in purchases)
    claims = Claims(True, 2, {"arrive": 2}, {"clean": paid} if skip else {}, paid if skip else 0, purchases)
    preference = WeightedSum({"clean": 1} if skip else {}, over="violation")
    trace = [frozenset[str](), *(frozenset({place}) for place in places)]
    rules = [Rule("clean", "G !carpet", skip=skip)]
    verdict = judge(claims, [Task("arrive", "F desk")], preference, trace, [Fraction(1)] * 2, rules=rules)
    return {check.name: check.words for check in verdict.checks if not check.holds}


def test_a_rule_that_is_kept_or_paid_for_is_no_objection() -> None:
    assert refuted(AROUND) == refuted(AROUND, skip=None) == refuted(OVER, PAID) == {}


def test_a_rule_that_is_broken_and_not_paid_for_refutes() -> None:
    assert refuted(OVER) == refuted(OVER, skip=None) == {"rule clean": "broken by action 1"}


@pytest.mark.parametrize(
    ("places", "purchase", "skip"),
    [
        (OVER, Purchase("clean", 2, None, 2, rule=True), 2),
        (OVER, Purchase("clean", 1, None, 1, rule=True), 2),
        (OVER, Purchase("tidy", 1, None, 2, rule=True), 2),
        (OVER, PAID, None),
        (AROUND, PAID, 2),
    ],
)
def test_what_is_paid_for_a_rule_is_its_price_when_it_is_broken(
    places: tuple[str, ...], purchase: Purchase, skip: int | None
) -> None:
    words = f"{purchase.task} is not a rule that may be broken at step {purchase.step} for {purchase.cost}"
    assert refuted(places, purchase, skip=skip)["relaxations"] == words


def test_what_is_paid_for_a_task_is_no_price_of_a_rule() -> None:
    found = refuted(OVER, Purchase("clean", 1, None, 2))
    assert (found["relaxations"], found["rule clean"]) == ("there is no task clean", "broken by action 1")


def test_a_claim_may_be_off_by_the_rounding_of_its_sum_and_by_no_more() -> None:
    for error, wrong in ((1e-10, []), (1e-8, ["total cost"])):
        claims = Claims(True, 3 + error, {"arrive": 3}, {}, 0)
        verdict = judge(
            claims,
            [Task("arrive", "F desk")],
            WeightedSum({"arrive": 0}),
            [frozenset(), frozenset({"desk"})],
            [Fraction(3)],
        )
        assert [check.name for check in verdict.checks if not check.holds] == wrong
