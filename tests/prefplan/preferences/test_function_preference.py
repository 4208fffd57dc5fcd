"""Preferences that are Python functions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from small_models import build

from prefplan import Function, PreferenceError, Problem, Rule, TransitionSystem, pareto_front


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
        (3, r"must be a function of \(costs, violations\), not 3 \(int\)"),
    ],
)
def test_a_function_that_is_no_preference_is_refused(function: Any, message: str) -> None:
    with pytest.raises(PreferenceError, match=f"^preference.function: {message}"):
        build(Function(function))


def test_a_function_reads_what_a_rule_costs_that_is_broken() -> None:
    system = TransitionSystem.from_transitions([("s", "go", "t", 1)], start="s", labels={"t": ["p"]})
    toll = Function(lambda costs, violations: violations[1], "componentwise")
    front = pareto_front(Problem(system, {"task": "F p"}, toll, rules=[Rule("rule", "G !p", skip=3)]))
    assert [(plan.cost, plan.preference) for plan in front] == [(1, 3)]


def at_the_end(mu: Callable[[], float]) -> Function:
    """Return a preference that is the first task's cost, and at the end of the only plan what is given."""
    return Function(lambda costs, violations: mu() if costs[0] == 3.25 else costs[0], "componentwise")


def fails() -> float:
    raise ValueError("three")


@pytest.mark.parametrize(
    ("mu", "message"),
    [
        (fails, "fails at .*phi1=3.25.*: three"),
        (lambda: float("nan"), "is nan at"),
        (lambda: -1.0, "negative"),
        (lambda: 1e300, r"is \d.*e\+30"),
    ],
)
def test_a_function_that_fails_in_the_middle_of_a_search_is_reported(mu: Callable[[], float], message: str) -> None:
    with pytest.raises(PreferenceError, match=message):
        pareto_front(build(at_the_end(mu)))


def test_ctrl_c_inside_a_function_stays_an_interrupt() -> None:
    def interrupted() -> float:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        pareto_front(build(at_the_end(interrupted)))
