"""Preferences and relaxations that cannot be used: each is refused by a sentence that names the place."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from prefplan import (
    Deadline,
    Due,
    Expression,
    FormulaError,
    Function,
    Max,
    Order,
    PreferenceError,
    PrefplanError,
    Problem,
    Relaxation,
    ScenarioError,
    Sum,
    Task,
    TransitionSystem,
    WeightedSum,
    cheapest_plan,
    pareto_front,
    preferred_plan,
)
from prefplan.measure import TASK_LIMIT
from prefplan.preference import Preference
from prefplan.scenario import from_dict

NAMES = ("phi1", "phi2", "phi3")


@pytest.fixture(scope="module")
def system() -> TransitionSystem:
    """Return s -1.25-> t -2-> u, with p in t, q in u, and r nowhere."""
    edges = [("s", "go", "t", 1.25), ("t", "on", "u", 2)]
    return TransitionSystem.from_transitions(
        edges, start="s", propositions=["p", "q", "r"], labels={"t": ["p"], "u": ["q"]}
    )


Build = Callable[..., Problem]


@pytest.fixture
def build(system: TransitionSystem) -> Build:
    def build(preference: Preference, names: Sequence[str] = NAMES, **task: Any) -> Problem:
        return Problem(system, [Task(name, "F q", **task) for name in names], preference)

    return build


VIOLATION = WeightedSum({name: 1 for name in NAMES}, over="violation")


# --- contracts -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("expression", "contract"),
    [
        ("phi1", "additive"),
        ("phi1 + 2*phi2", "additive"),
        ("3 * (phi1 + phi2 / 4) + 7", "additive"),
        ("2 * phi1 - phi1", "additive"),
        ("abs(phi1 - phi2) + phi3", "additive"),
        ("max(phi1, phi2, phi3) - min(phi1, phi2, phi3)", "additive"),
        ("max(2*phi1, phi2)", "convex"),
        ("max(0, phi1 - 5) * 2 + phi2", "convex"),
        ("max(2*phi1 - 5, 0) / 4 + abs(phi2 - phi3)", "convex"),
        ("max(3*phi1, phi3) + 2*phi2", "componentwise"),
        ("max(2*phi1, phi2) + max(phi2, 3*phi3)", "componentwise"),
        ("phi1 * phi2", "componentwise"),
        ("phi1 * phi1", "componentwise"),
        ("phi1 + min(phi2, 20)", "componentwise"),
        ("max(0, phi2 - phi1) / (1 + phi1)", "general"),
        ("abs(phi1 - phi2) * phi3", "general"),
        ("(phi1 - phi2) * (phi1 - phi2)", "general"),
        ("max(phi1, phi2) - min(phi1, phi3)", "general"),
    ],
)
def test_the_contract_of_an_expression_is_derived(build: Build, expression: str, contract: str) -> None:
    assert build(Expression(expression)).measure.contract == contract


@pytest.mark.parametrize(
    ("over", "expression", "contract"),
    [("violation", "phi1 + phi2", "additive"), ("violation", "max(0, phi1 - 5)", "componentwise")],
)
def test_the_contract_over_violation_costs_is_derived(build: Build, over: str, expression: str, contract: str) -> None:
    assert build(Expression(expression, over=over), skip=3).measure.contract == contract


def test_a_contract_may_be_declared_where_it_cannot_be_shown(build: Build) -> None:
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
def test_a_sum_has_the_weakest_contract_that_covers_its_terms(
    build: Build, parts: Sequence[Preference], contract: str
) -> None:
    assert build(Sum(tuple((part, 2) for part in parts))).measure.contract == contract


@pytest.mark.parametrize(
    ("expression", "contract"),
    [
        ("phi1 * phi2", "additive"),
        ("phi1 * phi2", "convex"),
        ("phi1 * phi1", "additive"),
        ("max(0, phi1 - 5)", "additive"),
        ("phi1 + min(phi2, 20)", "convex"),
        ("max(3*phi1, phi3) + 2*phi2", "convex"),
    ],
)
def test_a_declared_contract_that_fails_is_refuted_by_a_pair_of_labels(
    build: Build, expression: str, contract: str
) -> None:
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
def test_a_componentwise_contract_that_fails_is_refuted_by_a_pair_of_costs(
    build: Build, preference: Preference
) -> None:
    with pytest.raises(PreferenceError) as caught:
        build(preference)
    pair = r"\S+ at \(phi1=.*?\) but only \S+ at \(phi1=.*?\)"
    assert re.fullmatch(f"preference.contract: not componentwise: {pair}", str(caught.value))


# --- mu that falls, is negative or is not a number -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("preference", "where"),
    [
        (Expression("abs(phi1 - phi2)", over="violation"), "expression"),
        (Expression("max(phi1, phi2) - min(phi1, phi2)", over="violation"), "expression"),
        (Expression("phi1 / (1 + phi2)"), "expression"),
        (Function(lambda costs, violations: 1 / (1 + costs[0])), "function"),
        (Sum(((Order(), 1), (Expression("max(0, 20 - phi1)"), 1))), "terms[1].expression"),
    ],
)
def test_a_preference_that_falls_along_a_trajectory_is_refused(
    build: Build, preference: Preference, where: str
) -> None:
    with pytest.raises(PreferenceError) as caught:
        build(preference, skip=3)
    text = rf"preference.{re.escape(where)}: falls along a trajectory, from \S+ at \(phi1=.*\) to \S+ at \(phi1=.*\)"
    assert re.fullmatch(text, str(caught.value))


@pytest.mark.parametrize("expression", ["phi1 - phi2", "phi1 - 5", "10 - phi1", "-phi1", "-1"])
def test_a_preference_that_can_be_negative_is_refused(build: Build, expression: str) -> None:
    with pytest.raises(PreferenceError, match=r"^preference.expression: must not be negative, but is -\d+ at \(phi1="):
        build(Expression(expression))


# --- expressions -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ("phi1 / 0", "divides by '0', which can be zero"),
        ("phi1 / phi2", "divides by 'phi2', which can be zero"),
        ("phi1 / (phi2 - phi2)", "divides by '(phi2 - phi2)', which can be zero"),
        ("1 / abs(phi1 - phi2)", "divides by 'abs((phi1 - phi2))', which can be zero"),
        ("__import__('os')", "function '__import__' is not allowed (valid: min, max, abs), at column 1"),
        ("pow(phi1, 2)", "function 'pow' is not allowed (valid: min, max, abs), at column 1"),
        ("mix(phi1, phi2)", "function 'mix' is not allowed (did you mean 'min'?), at column 1"),
        ("phi1.real", "expected an operator, not '.', at column 5"),
        ("phi1 ** 2", "expected a number, a task or a bracket, not '*', at column 7"),
        ("phi1 ^ 2", "expected an operator, not '^', at column 6"),
        ("phi1 < phi2", "expected an operator, not '<', at column 6"),
        ("phi1 == phi2", "expected an operator, not '=', at column 6"),
        ("phi1 if phi2 else 3", "expected an operator, not 'if', at column 6"),
        ("phi1 phi2", "expected an operator, not 'phi2', at column 6"),
        ("phi1 // 2", "expected a number, a task or a bracket, not '/', at column 7"),
        ("[phi1]", "'[' is not allowed (only + - * / min max abs, numbers, brackets, tasks), at column 1"),
        ("'phi1'", '"\'" is not allowed (only + - * / min max abs, numbers, brackets, tasks), at column 1'),
        ("phi4", "unknown task 'phi4' (did you mean 'phi3'?), at column 1"),
        ("min", "unknown task 'min' (valid: phi1, phi2, phi3), at column 1"),
        ("", "expected a number, a task or a bracket, but it ends, at column 1"),
        ("phi1 +", "expected a number, a task or a bracket, but it ends, at column 7"),
        ("(phi1", "'(' is never closed, at column 1"),
        ("phi1)", "expected an operator, not ')', at column 5"),
        ("max()", "expected a number, a task or a bracket, not ')', at column 5"),
        ("abs(phi1, phi2)", "abs takes one argument, not 2, at column 1"),
        ("1_000 * phi1", "expected an operator, not '_000', at column 2"),
        ("(" * 150 + "phi1" + ")" * 150, "nested more than 100 deep, at column 101"),
    ],
)
def test_an_expression_that_cannot_be_read_is_refused(build: Build, expression: str, message: str) -> None:
    with pytest.raises(PreferenceError) as caught:
        build(Expression(expression))
    told, *drawing = str(caught.value).split("\n")
    assert told == f"preference.expression: {message}"
    if column := re.search(r"at column (\d+)$", message):
        assert drawing == [f"    {expression}", f"    {' ' * (int(column[1]) - 1)}^"]


# --- other preferences -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("preference", "message"),
    [
        (Max({"phi": 1}), "weights: unknown task 'phi' (did you mean 'phi3'?)"),
        (Max({"phi1": -1}), "weights.phi1: must not be negative, but is -1"),
        (Max(over="time"), "over: 'time' is unknown (valid: cost, violation)"),
        (WeightedSum({"phi1": 1, "phi2": 1}, over="violation"), "weights: every task needs one; missing phi3"),
        (WeightedSum({"phi1": 1, "phi2": 1, "phi3": 1}, over="violations"), "over: 'violations' is unknown (did you "),
        (Deadline({"phi1": Due(1)}, over="x"), "over: 'x' is unknown (valid: cost, violation)"),
        (Expression("phi1", contract="monotone"), "contract: 'monotone' is unknown (valid: additive, convex, "),
        (Expression("phi1", over="costs"), "over: 'costs' is unknown (did you mean 'cost'?)"),
        (Function(lambda c, v: c[0], contract="sum"), "contract: 'sum' is unknown (valid: additive, convex, "),
        (Sum(()), "terms: a sum needs at least one"),
        (Sum(((Order(), -2),)), "terms[0].weight: must not be negative, but is -2"),
        (Sum(((Order(), 1), (Max({"x": 1}), 1))), "terms[1].weights: unknown task 'x' (valid: phi1, phi2, phi3)"),
        (Sum(((Order(), 1), (Order(("phi1",)), 1))), "terms[1].order: every task needs a place; missing phi2, phi3"),
    ],
)
def test_a_preference_that_does_not_fit_names_the_key(build: Build, preference: Preference, message: str) -> None:
    with pytest.raises(PreferenceError, match="^" + re.escape(f"preference.{message}")):
        build(preference)


# --- relaxations -----------------------------------------------------------------------------------------------------


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
    build: Build, relaxation: tuple[str, str, int], error: type[PrefplanError], message: str
) -> None:
    good = Relaxation("r", "p", 1)
    with pytest.raises(error, match="^" + re.escape(f"tasks[0].relax[1].{message}")):
        build(VIOLATION, relax=(good, Relaxation(*relaxation)))


def test_a_negative_price_of_skipping_is_refused(build: Build) -> None:
    with pytest.raises(PrefplanError, match=r"^tasks\[0\].skip: negative cost -2$"):
        build(VIOLATION, skip=-2)


@pytest.mark.parametrize(
    "preference", [Order(), Max(), Expression("phi1"), Sum(((Order(), 1), (WeightedSum(dict.fromkeys(NAMES, 1)), 1)))]
)
@pytest.mark.parametrize(
    ("task", "key"), [({"relax": (Relaxation("r", "p", 1),)}, "relax"), ({"skip": 3}, "skip")], ids=["relax", "skip"]
)
def test_what_no_term_weighs_may_not_be_relaxed(
    build: Build, preference: Preference, task: dict[str, Any], key: str
) -> None:
    with pytest.raises(PrefplanError) as caught:
        build(preference, **task)
    assert str(caught.value) == (
        f"tasks[0].{key}: nothing in the preference weighs what it costs; "
        'give a term of the preference over = "violation"'
    )


# --- tasks and bounds ------------------------------------------------------------------------------------------------


def test_a_problem_needs_a_task_and_takes_no_more_than_the_limit(build: Build) -> None:
    with pytest.raises(PrefplanError, match=r"^tasks: a problem needs at least one task$"):
        build(Order(), names=[])
    too_many = [f"t{k}" for k in range(TASK_LIMIT + 1)]
    with pytest.raises(
        PrefplanError, match=rf"^tasks: {TASK_LIMIT + 1} are more than the {TASK_LIMIT} that the search can take$"
    ):
        build(Order(), names=too_many)


def test_a_general_contract_needs_a_bound_on_cost(build: Build) -> None:
    problem = build(Expression("abs(phi1 - phi2) * phi3"))
    assert problem.measure.contract == "general"
    for choose in (pareto_front, preferred_plan, lambda p: cheapest_plan(p, max_preference=3)):
        with pytest.raises(PreferenceError, match=r"^preference: its contract is 'general'.*\(--max-cost\)$"):
            choose(problem)
    assert [plan.cost for plan in pareto_front(problem, max_cost=10)] == [3.25]
    assert cheapest_plan(problem).cost == 3.25, "the cheapest plan of all needs no bound"


# --- Python functions ------------------------------------------------------------------------------------------------


def spoken(costs: Any, violations: Any) -> float:
    """Return the largest cost in a way that numba cannot compile."""
    return sorted({"cost": float(cost)}["cost"] for cost in costs)[-1]


@pytest.mark.parametrize(
    "function", [lambda costs, violations: costs.max(), spoken], ids=["compiled", "stays in Python"]
)
@pytest.mark.parametrize("contract", ["componentwise", "general", "convex"])
def test_a_python_function_is_a_preference(build: Build, function: Callable[[Any, Any], float], contract: str) -> None:
    problem = build(Function(function, contract))
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
def test_a_function_that_is_no_preference_is_refused(build: Build, function: Any, message: str) -> None:
    with pytest.raises(PreferenceError, match=f"^preference.function: {message}"):
        build(Function(function))


def test_a_function_that_stays_in_python_may_fail_in_the_middle_of_a_search(build: Build) -> None:
    """No trial cost is 3.25, so that it is the search that meets it."""

    def fragile(costs: Any, violations: Any) -> float:
        if max(costs) == 3.25:
            raise ValueError("sensor offline")
        return spoken(costs, violations)

    problem = build(Function(fragile, "componentwise"))
    with pytest.raises(PreferenceError, match="sensor offline"):
        pareto_front(problem)


# --- scenario files --------------------------------------------------------------------------------------------------


def scenario(preference: dict[str, Any], **task: Any) -> dict[str, Any]:
    """Return a file's content with two tasks, the first as given."""
    model = {
        "kind": "graph",
        "start": "s",
        "transitions": [{"from": "s", "to": "t", "cost": 1}],
        "labels": {"t": ["clean"]},
        "propositions": ["warm"],
    }
    tasks = [{"name": "wash", "formula": "F clean"} | task, {"name": "cook", "formula": "F clean"}]
    return {"model": model, "tasks": tasks, "preference": preference}


WEIGHED = {"kind": "weighted-sum", "weights": {"wash": 1, "cook": 1}, "over": "violation"}


def relax(assume: str, when: str, cost: Any) -> dict[str, Any]:
    return {"relax": [{"assume": assume, "when": when, "cost": cost}]}


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (scenario({}), "preference.kind: missing (valid: order, weighted-sum, "),
        (scenario({"kind": "weighted-sum"}), "preference.weights: missing"),
        (scenario({"kind": "weighted-sum", "weights": {"wash": 1}}), "preference.weights: every task needs one; "),
        (scenario({"kind": "max", "weights": {"wsh": 1}}), "preference.weights: unknown task 'wsh' (did you mean "),
        (scenario({"kind": "max", "weights": {"wash": -1}}), "preference.weights.wash: must not be negative"),
        (scenario({"kind": "max", "weights": {"wash": "1"}}), "preference.weights.wash: must be a number, not '1'"),
        (scenario({"kind": "max", "over": "time"}), "preference.over: should be 'cost' or 'violation'"),
        (scenario({"kind": "order", "over": "violation"}), "preference.over: unknown key"),
        (scenario({"kind": "deadline"}), "preference.deadlines: missing"),
        (scenario({"kind": "deadline", "deadlines": {"wash": {}}}), "preference.deadlines.wash.by: missing"),
        (scenario({"kind": "deadline", "deadlines": {"wsh": {"by": 3}}}), "preference.deadlines: unknown task 'wsh'"),
        (scenario({"kind": "expression"}), "preference.expression: missing"),
        (scenario({"kind": "expression", "expression": "wash / cook"}), "preference.expression: divides by 'cook'"),
        (scenario({"kind": "expression", "expression": "wash - cook"}), "preference.expression: must not be negative"),
        (
            scenario({"kind": "expression", "expression": "wash * cook", "contract": "convex"}),
            "preference.contract: not convex: mu grows from ",
        ),
        (scenario({"kind": "sum", "terms": []}), "preference.terms: a sum needs at least one"),
        (scenario({"kind": "sum", "terms": [{"kind": "sum"}]}), "preference.terms[0].kind: unknown kind 'sum'"),
        (
            scenario({"kind": "sum", "terms": [{"kind": "order"}, {"kind": "max", "weights": {"x": 1}}]}),
            "preference.terms[1].weights: unknown task 'x' (valid: wash, cook)",
        ),
        (scenario({"kind": "sum", "terms": [{"kind": "order", "weight": -1}]}), "preference.terms[0].weight: must not"),
        (scenario(WEIGHED, **relax("wet", "clean", 1)), "tasks[0].relax[0].assume: unknown proposition 'wet'"),
        (scenario(WEIGHED, **relax("warm", "X clean", 1)), "tasks[0].relax[0].when: 'X clean' has a temporal operator"),
        (scenario(WEIGHED, **relax("warm", "clean", -1)), "tasks[0].relax[0].cost: negative cost -1"),
        (scenario(WEIGHED, **relax("warm", "clean", "1")), "tasks[0].relax[0].cost: must be a number, not '1'"),
        (scenario(WEIGHED, skip=-3), "tasks[0].skip: negative cost -3"),
        (scenario({"kind": "order"}, skip=3), "tasks[0].skip: nothing in the preference weighs what it costs"),
        (scenario({"kind": "order"}) | {"tasks": []}, "tasks: a problem needs at least one task"),
    ],
)
def test_a_scenario_file_is_refused_by_file_and_key(data: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError, match="^" + re.escape(f"kitchen: {message}")):
        from_dict(data, name="kitchen").problem()


def test_a_scenario_file_may_hold_no_more_tasks_than_the_limit() -> None:
    tasks = [{"name": f"t{k}", "formula": "F clean"} for k in range(TASK_LIMIT + 1)]
    with pytest.raises(ScenarioError, match=f"kitchen: tasks: {TASK_LIMIT + 1} are more than the {TASK_LIMIT} "):
        from_dict(scenario({"kind": "order"}) | {"tasks": tasks}, name="kitchen").problem()
