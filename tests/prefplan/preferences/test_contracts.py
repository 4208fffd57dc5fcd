"""Contracts of preferences: derived, declared, refuted, and the cost bound that a general one needs."""

from __future__ import annotations

import re
from collections.abc import Sequence

import pytest
from small_models import build

from prefplan import (
    Deadline,
    Due,
    Expression,
    Function,
    Max,
    Order,
    PreferenceError,
    Sum,
    WeightedSum,
    cheapest_plan,
    pareto_front,
    preferred_plan,
)
from prefplan.preferences import kinds
from prefplan.preferences.kinds import Preference


@pytest.mark.parametrize(
    ("expression", "contract"),
    [
        ("phi1 + 2*phi2", "additive"),
        ("3 * (phi1 + phi2 / 4) + 7", "additive"),
        ("abs(phi1 - phi2) + phi3", "additive"),
        ("max(phi1, phi2, phi3) - min(phi1, phi2, phi3)", "additive"),
        ("max(2*phi1, phi2)", "convex"),
        ("max(0, phi1 - 5) * 2 + phi2", "convex"),
        ("max(2*phi1 - 5, 0) / 4 + abs(phi2 - phi3)", "convex"),
        ("max(3*phi1, phi3) + 2*phi2", "componentwise"),
        ("phi1 * phi2", "componentwise"),
        ("phi1 + min(phi2, 20)", "componentwise"),
        ("abs(phi1 - phi2) * phi3", "general"),
        ("max(phi1, phi2) - min(phi1, phi3)", "general"),
    ],
)
def test_the_contract_of_an_expression_is_derived(expression: str, contract: str) -> None:
    assert build(Expression(expression)).measure.contract == contract


@pytest.mark.parametrize(
    ("over", "expression", "contract"),
    [("violation", "phi1 + phi2", "additive"), ("violation", "max(0, phi1 - 5)", "componentwise")],
)
def test_the_contract_over_violation_costs_is_derived(over: str, expression: str, contract: str) -> None:
    assert build(Expression(expression, over=over), skip=3).measure.contract == contract


@pytest.mark.parametrize(
    ("expression", "tried"),
    [
        ("phi1 * phi2 + 1", False),
        ("max(phi1, phi2) - min(phi1, phi2)", False),
        ("abs(phi1 - phi2) + max(0, phi3 - 4)", False),
        ("phi1 + phi2 - min(phi2, 3)", True),
        ("abs(phi1 - phi2) * phi3", True),
    ],
)
def test_costs_are_tried_only_where_it_is_not_shown_that_mu_never_falls(
    expression: str, tried: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[str] = []
    monkeypatch.setattr(kinds, "check_never_falls", lambda whole, names, where: calls.append(where))
    Expression(expression).terms(("phi1", "phi2", "phi3"))
    assert bool(calls) == tried


def test_mu_that_grows_too_large_is_refused() -> None:
    with pytest.raises(PreferenceError, match=r"expression: (is|fails at).*phi1=2000"):
        Expression(" * ".join(["phi1"] * 100)).terms(("phi1",))


def test_a_contract_may_be_declared_where_it_cannot_be_shown() -> None:
    square = Expression("phi1 * phi1 + phi2")
    assert build(square).measure.contract == "componentwise"
    assert build(Expression(square.expression, contract="convex")).measure.contract == "convex"
    assert build(Expression("phi1 + phi2", contract="general")).measure.contract == "general"


@pytest.mark.parametrize(
    ("parts", "contract"),
    [
        ([Order(), WeightedSum({"phi1": 1, "phi2": 0, "phi3": 2})], "additive"),
        ([Order(), Deadline({"phi1": Due(3)})], "convex"),
        ([Max()], "convex"),
        ([Max(), Order()], "componentwise"),
        ([Max({"phi1": 2}), Max({"phi2": 2})], "componentwise"),
        ([Order(), Expression("abs(phi1 - phi2) * phi3")], "general"),
    ],
)
def test_a_sum_has_the_weakest_contract_that_covers_its_terms(parts: Sequence[Preference], contract: str) -> None:
    assert build(Sum(tuple((part, 2) for part in parts))).measure.contract == contract


@pytest.mark.parametrize(
    ("expression", "contract"),
    [
        ("phi1 * phi2", "additive"),
        ("phi1 * phi2", "convex"),
        ("max(3*phi1, phi3) + 2*phi2", "convex"),
        # Only labels with equal mu grow unequally.
        ("min(phi1, max(0, phi2 - 10), 0.01)", "convex"),
    ],
)
def test_a_declared_contract_that_fails_is_refuted_by_a_pair_of_labels(expression: str, contract: str) -> None:
    with pytest.raises(PreferenceError) as caught:
        build(Expression(expression, contract=contract))
    growth = r"from \S+ at \(phi1=.*?\) to \S+ at \(phi1=.*?\)"
    assert re.fullmatch(f"preference.contract: not {contract}: mu grows {growth}, but {growth}", str(caught.value))


@pytest.mark.parametrize(
    "preference",
    [
        Expression("abs(phi1 - phi2)", contract="componentwise"),
        Expression("max(0, phi2 - phi1) / (1 + phi1)", contract="componentwise"),
        Function(lambda costs, violations: abs(costs[0] - costs[1]), contract="componentwise"),
    ],
)
def test_a_componentwise_contract_that_fails_is_refuted_by_a_pair_of_costs(preference: Preference) -> None:
    with pytest.raises(PreferenceError) as caught:
        build(preference)
    pair = r"\S+ at \(phi1=.*?\) but only \S+ at \(phi1=.*?\)"
    assert re.fullmatch(f"preference.contract: not componentwise: {pair}", str(caught.value))


def test_a_general_contract_needs_a_bound_on_cost() -> None:
    problem = build(Expression("abs(phi1 - phi2) * phi3"))
    assert problem.measure.contract == "general"
    for choose in (pareto_front, preferred_plan, lambda p: cheapest_plan(p, max_preference=3)):
        with pytest.raises(
            PreferenceError, match=r"^preference: its contract is 'general'.*\(--max-cost C, in Python max_cost=C\)$"
        ):
            choose(problem)
    assert [plan.cost for plan in pareto_front(problem, max_cost=10)] == [3.25]
    assert cheapest_plan(problem).cost == 3.25, "the cheapest plan of all needs no bound"
