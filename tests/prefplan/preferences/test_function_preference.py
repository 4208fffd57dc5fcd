"""Preferences that are Python functions."""

from __future__ import annotations

from typing import Any

import pytest
from small_models import build

from prefplan import Function, PreferenceError, pareto_front


@pytest.mark.parametrize("contract", ["componentwise", "general", "convex"])
def test_a_python_function_is_a_preference(contract: str) -> None:
    problem = build(Function(lambda costs, violations: costs.max(), contract))
    assert problem.measure.contract == contract
    assert [(plan.cost, plan.preference) for plan in pareto_front(problem, max_cost=10)] == [(3.25, 3.25)]


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda costs, violations: -costs[0], r"must not be negative, but is -\d+ at \(phi1="),
        (lambda costs, violations: float("nan"), r"is nan at \(phi1="),
        (lambda costs, violations: float("inf"), r"is inf at \(phi1="),
        (lambda costs, violations: costs[7], r"fails at \(phi1=.*\): index 7 is out of bounds"),
        (lambda costs, violations: None, r"fails at \(phi1=.*\): float\(\) argument must be"),
        (lambda costs: costs[0], r"fails at \(phi1=.*\): .* takes 1 positional argument but 2 were given"),
        (3, r"fails at \(phi1=.*\): 'int' object is not callable"),
    ],
)
def test_a_function_that_is_no_preference_is_refused(function: Any, message: str) -> None:
    with pytest.raises(PreferenceError, match=f"^preference.function: {message}"):
        build(Function(function))


def test_a_function_may_fail_in_the_middle_of_a_search() -> None:
    tried = True

    def fragile(costs: Any, violations: Any) -> float:
        if not tried:
            raise ValueError("sensor offline")
        return float(costs.max())

    problem = build(Function(fragile, "componentwise"))
    tried = False
    with pytest.raises(PreferenceError, match="sensor offline"):
        pareto_front(problem)
