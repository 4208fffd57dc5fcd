"""What users get wrong, or right in a way one would not think of, at the edges of the public API."""

from __future__ import annotations

from decimal import Decimal

import networkx as nx
import numpy as np
import pytest

from prefplan import (
    Deadline,
    Due,
    ManipulationModel,
    ModelError,
    Order,
    PrefplanError,
    Problem,
    Task,
    TransitionSystem,
    automaton,
    cheapest_plan,
    pareto_front,
    parse,
)


def line(cost: object) -> TransitionSystem:
    return TransitionSystem.from_transitions([("s", "go", "e", cost)], start="s", labels={"e": ["a"]})


def test_costs_that_a_deadline_makes_too_large_are_refused() -> None:
    with pytest.raises(PrefplanError, match="too large"):
        pareto_front(Problem(line(4 * 10**18), [Task("t", "F a")], Deadline({"t": Due(0.5)})))


@pytest.mark.parametrize("cost", [Decimal("nan"), float("nan"), "3"])
def test_a_cost_that_is_no_number_is_refused(cost: object) -> None:
    with pytest.raises(ModelError):
        line(cost)


@pytest.mark.parametrize("text", [" & ".join(["a"] * 2000), " | ".join(["F a"] * 900), "(" * 190 + "a" + ")" * 190])
def test_a_long_formula_is_read_or_refused_without_a_stack_overflow(text: str) -> None:
    try:
        automaton(text)
    except PrefplanError:
        pass


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
