"""What users get wrong, or right in a way one would not think of, at the edges of the public API."""

from __future__ import annotations

from decimal import Decimal

import networkx as nx
import numpy as np
import pytest

from prefplan import (
    Deadline,
    Due,
    Expression,
    Function,
    ManipulationModel,
    ModelError,
    Order,
    PreferenceError,
    PrefplanError,
    Problem,
    Task,
    TransitionSystem,
    cheapest_plan,
    pareto_front,
    parse,
)
from prefplan.logic.dfa import automaton


def line(cost: object) -> TransitionSystem:
    return TransitionSystem.from_transitions([("s", "go", "e", cost)], start="s", labels={"e": ["a"]})


def test_costs_that_a_deadline_makes_large_are_exact() -> None:
    front = pareto_front(Problem(line(4 * 10**18), [Task("t", "F a")], Deadline({"t": Due(Decimal("0.5"))})))
    assert [(plan.cost, plan.preference) for plan in front] == [(4 * 10**18, 4 * 10**18)]


@pytest.mark.parametrize("cost", [Decimal("nan"), float("nan"), "3"])
def test_a_cost_that_is_no_number_is_refused(cost: object) -> None:
    with pytest.raises(ModelError):
        line(cost)


@pytest.mark.parametrize("text", [" & ".join(["a"] * 2000), " | ".join(["F a"] * 900), "(" * 190 + "a" + ")" * 190])
def test_a_long_formula_is_read_or_refused_without_a_stack_overflow(text: str) -> None:
    try:
        assert automaton(text).size > 1
    except PrefplanError as error:
        assert str(error)


def test_brackets_have_a_limit() -> None:
    with pytest.raises(PrefplanError, match="nested more than"):
        parse("(" * 10_000 + "a" + ")" * 10_000)


def test_a_table_without_locations_has_one_state() -> None:
    costs = {"transit": 1, "grasp": 1, "transport": 1, "release": 1}
    try:
        assert ManipulationModel("home", costs, (), ()).transition_system().size == 1
    except PrefplanError:
        pass


def test_numpy_numbers_are_numbers() -> None:
    assert line(np.float64(0.1)).step(0, "go")[1] == 0.1


def test_one_name_is_no_list_of_propositions() -> None:
    with pytest.raises(ModelError):
        TransitionSystem.from_transitions([("s", "go", "e", 1)], start="s", labels={"e": "plant"})


def test_an_undirected_graph_is_refused() -> None:
    with pytest.raises(ModelError):
        TransitionSystem.from_networkx(nx.Graph([("a", "b")]), start="a")


@pytest.mark.parametrize("cost", [2**53 + 1, 10**17 + 1])
def test_bounds_are_as_exact_as_costs(cost: int) -> None:
    problem = Problem(line(cost), [Task("t", "F a")], Order())
    assert pareto_front(problem, max_cost=cost)
    assert not pareto_front(problem, max_cost=cost - 1)
    assert cheapest_plan(problem, max_preference=0).cost == cost


def two_steps() -> TransitionSystem:
    return TransitionSystem.from_transitions(
        [("s", "go", "t", 1.25), ("t", "on", "u", 2)], start="s", labels={"t": ["p"], "u": ["q"]}
    )


def raises(costs: object, violations: object) -> float:
    if costs[0] == 3.25:  # type: ignore[index]
        raise ValueError("three")
    return costs[0]  # type: ignore[index, no-any-return]


def is_nan(costs: object, violations: object) -> float:
    return float("nan") if costs[0] == 3.25 else costs[0]  # type: ignore[index]


def is_negative(costs: object, violations: object) -> float:
    return -1.0 if costs[0] == 3.25 else costs[0]  # type: ignore[index]


def is_huge(costs: object, violations: object) -> float:
    return 1e300 * costs[0]  # type: ignore[index, no-any-return]


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (raises, "fails at .*phi=3.25.*: three"),
        (is_nan, "is nan at"),
        (is_negative, "negative"),
        (is_huge, r"is \d.*e\+30"),
    ],
)
def test_a_function_that_fails_in_the_middle_of_a_search_is_reported(function: object, message: str) -> None:
    with pytest.raises(PreferenceError, match=message):
        pareto_front(Problem(two_steps(), [Task("phi", "F q")], Function(function, "componentwise")))  # type: ignore[arg-type]


def test_ctrl_c_inside_a_function_stays_an_interrupt() -> None:
    def interrupted(costs: object, violations: object) -> float:
        if costs[0] == 3.25:  # type: ignore[index]
            raise KeyboardInterrupt
        return float(str(costs[0]))  # type: ignore[index]

    with pytest.raises(KeyboardInterrupt):
        pareto_front(Problem(two_steps(), [Task("phi", "F q")], Function(interrupted, "componentwise")))


def test_a_function_that_compiles_to_something_else_stays_in_python() -> None:
    def through_text(costs: object, violations: object) -> float:
        return float(str(costs[0]))  # type: ignore[index]

    front = pareto_front(Problem(two_steps(), [Task("phi", "F q")], Function(through_text, "componentwise")))
    assert [(plan.cost, plan.preference) for plan in front] == [(3.25, 3.25)]


@pytest.mark.parametrize("text", ["1e400 * phi", "1e999999999 * phi", "1e-999999 * phi", "+".join(["phi"] * 5000)])
def test_expressions_beyond_reason_are_refused(text: str) -> None:
    with pytest.raises(PreferenceError, match="preference.expression: "):
        Problem(two_steps(), [Task("phi", "F q")], Expression(text))
