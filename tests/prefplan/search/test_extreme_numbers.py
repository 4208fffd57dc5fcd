"""Numbers that do not fit 64 bits, computed numbers, and bounds equal to printed values."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction
from typing import Any

import networkx as nx
import pytest
from judge.planners import ReferencePlanner

from prefplan import (
    Deadline,
    Due,
    Expression,
    Front,
    Function,
    Max,
    NamedPreference,
    NoPlanError,
    Order,
    PreferenceError,
    Problem,
    Sum,
    Task,
    TransitionSystem,
    WeightedSum,
    cheapest_plan,
    pareto_front,
)
from prefplan.errors import ModelError
from prefplan.front import Reason
from prefplan.logic.tasks import Relaxation
from prefplan.preferences.kinds import Preference


def points(front: Front) -> list[tuple[Any, Any]]:
    return [(plan.cost, plan.preference) for plan in front]


def agreed(problem: Problem, **bounds: Any) -> list[tuple[Any, Any]]:
    """Return the points of a front, which Python's integers must find, too."""
    front = pareto_front(problem, **bounds)
    assert front.complete
    assert points(front) == points(ReferencePlanner(problem).front(**bounds))
    return points(front)


def line(cost: Any) -> TransitionSystem:
    return TransitionSystem.from_transitions([("s", "go", "t", cost)], start="s", labels={"t": ["a"]})


def fork(*costs: tuple[Any, Any]) -> TransitionSystem:
    """Return a system on which a and b can be done in this order or the other, each at two costs."""
    edges = []
    for k, (first, second) in enumerate(costs):
        edges += [("s", f"go{k}", f"m{k}", first), (f"m{k}", "on", f"e{k}", second)]
    labels = {f"m{k}": ["ab"[k % 2]] for k in range(len(costs))} | {f"e{k}": ["ba"[k % 2]] for k in range(len(costs))}
    return TransitionSystem.from_transitions(edges, start="s", labels=labels)


TASKS = [Task("p", "F a"), Task("q", "F b")]


@pytest.mark.parametrize(
    ("cost", "skip", "weight", "expected"),
    [
        (10, 400, Decimal("0.3333333333333333"), [(0, 133.33333333333332), (10, 0)]),
        (0.1 + 0.2, 3, 4, [(0, 12), (0.3, 0)]),
        (Decimal("1e300"), Decimal("1e-300"), Decimal("1e200"), [(0, 1e-100), (10**300, 0)]),
        (1e-300, 1e300, 1e-300, [(0, 1), (1e-300, 0)]),
        (Fraction(1, 3), Fraction(1, 7), Fraction(1, 11), [(0, 1 / 77), (1 / 3, 0)]),
    ],
)
def test_a_point_is_found_whatever_the_size_and_digits_of_numbers(
    cost: Any, skip: Any, weight: Any, expected: list
) -> None:
    preference = WeightedSum({"p": weight}, over="violation")
    assert points(pareto_front(Problem(line(cost), [Task("p", "F a", skip=skip)], preference))) == expected


@pytest.mark.parametrize("factor", [1, 2**40, 2**58, 2**64, 10**30, Fraction(1, 3), Decimal("1e-17")])
@pytest.mark.parametrize("preference", [Order(), WeightedSum({"p": 7, "q": 2}), Expression("p * q + p")])
def test_fronts_scale_with_their_costs(factor: Any, preference: Preference) -> None:
    """Compiled search and Python's integers meet: the same front in other units."""
    costs = [(3, 7), (4, 2), (1, 9), (8, 1)]
    plain = pareto_front(Problem(fork(*costs), TASKS, preference))
    scaled = pareto_front(Problem(fork(*((x * factor, y * factor) for x, y in costs)), TASKS, preference))
    assert [plan.actions for plan in scaled] == [plan.actions for plan in plain]
    assert [plan.cost for plan in scaled] == pytest.approx([plan.cost * float(factor) for plan in plain], rel=1e-15)


@pytest.mark.parametrize("power", range(54, 67, 2))
@pytest.mark.parametrize("preference", [Max({"p": 1, "q": 3}), WeightedSum({"p": 1, "q": 3}), Order()])
def test_values_about_the_limit_of_64_bits_are_not_taken_for_out_of_bounds(power: int, preference: Preference) -> None:
    assert agreed(Problem(fork((2**power, 1), (2**power - 3, 9)), TASKS, preference))
    assert cheapest_plan(Problem(fork((2**power, 1)), TASKS, preference)).cost == 2**power + 1


def test_payments_on_a_cycle_without_cost_end() -> None:
    """Under a general contract, violation costs grow without end along such a cycle, at the same cost."""
    system = TransitionSystem.from_transitions(
        [("s", "go", "t", 0), ("t", "back", "s", 0), ("t", "on", "u", 2)],
        start="s",
        labels={"s": ["a"], "t": ["b"], "u": ["c"]},
    )
    tasks = [
        Task("p", "F (c & a)", (Relaxation("a", "true", 1),), skip=9),
        Task("q", "a U (b & X (b U c))", (Relaxation("b", "a", 1), Relaxation("c", "b", 5)), skip=7),
    ]
    mu = Sum(((Expression("abs(p - q) * q", contract="general"), 1), (WeightedSum({"p": 1, "q": 1}, "violation"), 1)))
    assert agreed(Problem(system, tasks, mu), max_cost=4)


def test_tiny_values_of_quotients_stay_apart() -> None:
    costs = [(k * Decimal("1e-8"), (40 - 2 * k) * Decimal("1e-8")) for k in range(1, 19, 2)]
    system = fork(*(cost for cost in costs for _ in range(2)))
    assert len(agreed(Problem(system, TASKS, Expression("1 - 0.5 / (1 + p)")), max_cost=1)) == 9


@pytest.fixture(scope="module")
def roads() -> TransitionSystem:
    graph = nx.random_geometric_graph(300, 0.12, seed=5).to_directed()
    where = nx.get_node_attributes(graph, "pos")
    for source, target, data in graph.edges(data=True):
        data["cost"] = math.dist(where[source], where[target])
    nodes = max(nx.strongly_connected_components(graph), key=len)
    for name, node in zip("abcd", sorted(nodes)[::70], strict=False):
        graph.nodes[node]["labels"] = [name]
    return TransitionSystem.from_networkx(graph.subgraph(nodes).copy(), start=max(nodes))


def test_distances_in_doubles_are_planned_with_at_a_stated_resolution(roads: TransitionSystem) -> None:
    tasks = [Task(name, f"F {name}") for name in sorted(roads.propositions)]
    problem = Problem(roads, tasks, Order())
    front = pareto_front(problem)
    assert front.complete and problem.resolution == 1e-12
    assert front.assumptions == ("Costs are rounded to multiples of 1e-12; the front is exact for those.",)
    for plan in front:
        before = map(roads.states.index, plan.states[:-1])
        steps = [roads.step(state, action)[1] for state, action in zip(before, plan.actions, strict=True)]
        assert plan.cost == pytest.approx(math.fsum(map(float, steps)), abs=1e-12)
        assert (Fraction(str(plan.cost)) / Fraction(str(problem.resolution))).denominator == 1


@pytest.mark.parametrize("names", ["cd", "dc"])
def test_what_is_rounded_is_told_whichever_cost_it_is(names: str) -> None:
    small, large = ({"c": 1, "d": cost} for cost in (0.123456789012347, 123.456789012343))
    edges = [("a", "x", "b", small), ("b", "y", "c", large)]
    edges = [(*edge, {name: costs[name] for name in names}) for *edge, costs in edges]
    system = TransitionSystem.from_transitions(edges, start="a", labels={"c": {"p"}})
    front = pareto_front(Problem(system, [Task("p", "F p")], Order()))
    assert front.assumptions == ("Costs are rounded to multiples of 1e-09; the front is exact for those.",)


def test_decimals_that_people_write_are_never_rounded() -> None:
    front = pareto_front(Problem(fork((10**17, 0.001)), TASKS, Order()))
    assert not front.assumptions and front[0].cost == 1e17 and front[0].task_costs["p"] == 10**17
    assert cheapest_plan(Problem(line(0.001), TASKS[:1], Order())).cost == 0.001


@pytest.mark.parametrize("weights", [{"p": 1 / 3, "q": 2 / 3}, {"p": Decimal("0.1234567890123456789"), "q": 7}])
def test_what_is_printed_is_a_bound_that_admits_its_plan(weights: dict) -> None:
    system = fork((Decimal("2.3"), 1), (0.1 + 0.2, Decimal("4.9")), (0.7, 9), (Decimal("1e-9"), 6))
    problem = Problem(system, TASKS, WeightedSum(weights))
    front = pareto_front(problem)
    assert len(front) > 1
    for plan in front:
        for read in (lambda number: number, lambda number: Decimal(str(number)), lambda number: float(str(number))):
            assert cheapest_plan(problem, max_preference=read(plan.preference)) == plan
            assert pareto_front(problem, max_cost=read(plan.cost))[-1] == plan
    with pytest.raises(NoPlanError):
        cheapest_plan(problem, max_preference=math.nextafter(front[-1].preference, 0))


def test_hundreds_of_relaxations_of_one_task_are_read_at_once() -> None:
    names = [f"n{k}" for k in range(200)]
    system = TransitionSystem.from_transitions(
        [("s", "go", "t", 1)], start="s", labels={"t": ["a"]}, propositions=names
    )
    relax = tuple(Relaxation(name, "a", 1 + k % 3) for k, name in enumerate(names + names))
    task = Task("p", f"F ({' & '.join(names)})", relax)
    front = pareto_front(Problem(system, [task], WeightedSum({"p": 1}, over="violation")))
    assert points(front) == [(1, sum(min(1 + k % 3, 1 + (k + 200) % 3) for k in range(200)))]


def test_too_many_ways_to_read_a_label_are_refused_with_their_number() -> None:
    tasks = [Task(f"t{k}", "F a", (Relaxation("a", "true", 1),), skip=2) for k in range(20)]
    problem = Problem(line(1), tasks, WeightedSum({task.name: 1 for task in tasks}, over="violation"))
    with pytest.raises(ModelError, match="3,486,784,401 ways"):
        pareto_front(problem)


def falling(costs: Any, violations: Any) -> float:
    return float(costs[0] if costs[0] < 5000 else 4000 - costs[1] / 1e9)


def test_a_claim_is_tried_on_costs_as_large_as_the_problems() -> None:
    preference = Function(falling, "componentwise")
    assert pareto_front(Problem(fork((1, 2), (2, 1)), TASKS, preference)).assumptions
    assert not pareto_front(Problem(fork((1, 2), (2, 1)), TASKS, Expression("p * q", "componentwise"))).assumptions
    with pytest.raises(PreferenceError, match="^preference: (falls|not componentwise)"):
        Problem(fork((4000, 2000), (2000, 4001)), TASKS, preference)


@pytest.mark.parametrize("cost", [1, 10**20])
def test_a_fall_that_trials_missed_is_met_by_the_search(cost: int) -> None:
    def narrow(costs: Any, violations: Any) -> float:
        return 0.0 if max(costs) == 104729.5 else float(max(costs))

    system = TransitionSystem.from_transitions(
        [("s", "go", "t", 104728), ("t", "on", "u", 1.5), ("u", "back", "s", cost)],
        start="s",
        labels={"u": ["a"], "t": ["b"]},
    )
    with pytest.raises(PreferenceError, match=r"mu falls along a trajectory.*104730|mu falls .*p=104730"):
        pareto_front(Problem(system, TASKS, Function(narrow, "componentwise")))


@pytest.mark.parametrize("cost", [1, 10**20])
@pytest.mark.parametrize(
    ("value", "words"),
    [("nan", "is nan"), ("inf", "is inf"), ("-1", "must not be negative, but is -1"), ("x", "fails")],
)
def test_a_function_without_a_value_is_told_whatever_the_size_of_numbers(cost: int, value: str, words: str) -> None:
    def gap(costs: Any, violations: Any) -> float:
        return float(value if costs[0] == 104729 else max(costs))

    system = TransitionSystem.from_transitions(
        [("s", "go", "t", 104729), ("t", "on", "u", 2), ("u", "back", "s", cost)],
        start="s",
        labels={"t": ["a"], "u": ["b"]},
    )
    named = [NamedPreference("first", Order()), NamedPreference("second", Function(gap, "componentwise"))]
    with pytest.raises(PreferenceError, match=f"^preferences.second: {words}.*p=104729"):
        pareto_front(Problem(system, TASKS, named))


NOTHING = Expression("p - p / (1 + p) - min(p, q) * min(p, q) / (1 + min(p, q))")
"""0 where both tasks cost the same; in floats 2e-16 at 2."""


def test_a_value_that_is_zero_is_within_a_bound_of_zero() -> None:
    problem = Problem(line(2), {"p": "F a", "q": "F a"}, NOTHING)
    assert cheapest_plan(problem, max_cost=2, max_preference=0).actions == ("go",)


def test_a_value_that_is_less_only_if_rounded_does_not_fall() -> None:
    system = TransitionSystem.from_transitions(
        [("s", "go", "t", 2), ("t", "on", "u", 1)], start="s", labels={"u": ["a"]}
    )
    assert agreed(Problem(system, {"p": "F a", "q": "F a"}, NOTHING), max_cost=9) == [(3, 0)]


def test_costs_that_a_deadline_makes_large_are_exact() -> None:
    front = pareto_front(Problem(line(4 * 10**18), TASKS[:1], Deadline({"p": Due(Decimal("0.5"))})))
    assert points(front) == [(4 * 10**18, 4 * 10**18)]


@pytest.mark.parametrize("cost", [2**53 + 1, 10**17 + 1])
def test_bounds_are_as_exact_as_costs(cost: int) -> None:
    problem = Problem(line(cost), TASKS[:1], Order())
    assert pareto_front(problem, max_cost=cost)
    assert not pareto_front(problem, max_cost=cost - 1)
    assert cheapest_plan(problem, max_preference=0).cost == cost


def test_why_there_is_no_plan_is_said_whatever_the_size_of_numbers() -> None:
    system = fork((10**30, 1), (2 * 10**30, 3))
    with pytest.raises(NoPlanError) as caught:
        cheapest_plan(Problem(system, {"a": "F a", "b": "F b"}, Order()), max_cost=5)
    assert caught.value.reason == Reason("bound", smallest=10**30 + 1)
    front = pareto_front(Problem(system, {"a": "F a", "c": "F (b & X b)"}, Order()))
    assert front.reason == Reason("task", ("c",))


def test_python_integers_keep_limits_of_time() -> None:
    costs = [(k * 10**25 + 1, (37 * k % 101) * 10**25) for k in range(1, 60)]
    assert pareto_front(Problem(fork(*costs), TASKS, Order()), max_seconds=0).ended == "time"
