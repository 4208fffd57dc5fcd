"""Every contract, relaxations included, against an exhaustive search: thousands of small problems, and known traps."""

from __future__ import annotations

import judge
import pytest
from judge.examples import TRAPS, graph
from judge.verdict import WAYS, misjudged, verdict
from small_models import TOWN

from prefplan import Options, Planner
from prefplan.scenario.decode import from_dict

BLOCK = 50
"""Problems that one test looks at, so that thousands of them are few tests."""

#: Kind of preference, whether over violation costs of relaxed tasks, how many problems.
DRAWN = (
    ("order", False, 200),
    ("weighted-sum", False, 200),
    ("max", False, 250),
    ("deadline", False, 200),
    ("sum", False, 250),
    ("expression", False, 150),
    ("weighted-sum", True, 250),
    ("max", True, 250),
    ("sum", True, 300),
)


@pytest.mark.parametrize(
    ("kind", "relaxed", "first"),
    [
        pytest.param(kind, relaxed, first, id=f"{kind}-{'relaxed-' if relaxed else ''}{first}")
        for kind, relaxed, number in DRAWN
        for first in range(0, number, BLOCK)
    ],
)
def test_fronts_bounds_and_plans_are_those_of_the_exhaustive_search(kind: str, relaxed: bool, first: int) -> None:
    """All ways to search are held against the judges on every fifth problem, the usual one on the others."""
    wrong = {}
    for seed in range(first, first + BLOCK):
        decimals = (0, 0, 1, 0, 0, 2, 0)[seed % 7]
        problem = judge.random_problem(seed, kind=kind, relaxed=relaxed, decimals=decimals)
        wrong[seed, decimals] = verdict(problem, WAYS if seed % 5 == 0 else WAYS[:1])
    assert not {drawn: told for drawn, told in wrong.items() if told}


def test_relaxations_and_skips_are_used_by_the_problems_drawn() -> None:
    """Many of their plans must have bought something, or the relaxed problems show little."""
    problems = [judge.random_problem(seed, kind="weighted-sum", relaxed=True) for seed in range(60)]
    fronts = [Planner(from_dict(problem.scenario()).problem()).front() for problem in problems]
    bought = [purchase for front in fronts for plan in front for purchase in plan.relaxations]
    assert sum(purchase.assume is None for purchase in bought) >= 5
    assert sum(purchase.assume is not None and purchase.step > 0 for purchase in bought) >= 5
    assert sum(len(front) > 1 for front in fronts) >= 10


@pytest.mark.parametrize("name", TRAPS)
@pytest.mark.parametrize("options", WAYS, ids=repr)
def test_points_that_pruning_by_cost_and_mu_would_lose_are_found(name: str, options: Options) -> None:
    problem, points = TRAPS[name]
    assert judge.exact_front(problem, max_cost=100) == points
    planned = from_dict(problem.scenario()).problem()
    assert planned.measure.contract == "componentwise"
    front = Planner(planned, options=options).front()
    assert [(plan.cost, plan.preference) for plan in front] == points
    assert not [wrong for plan in front if (wrong := misjudged(problem, plan))]


def test_a_spread_keeps_a_point_that_pruning_by_cost_vectors_would_lose() -> None:
    """At y the vector (1, 3) dominates (2, 3), yet the later phi1 is the better one."""
    problem, points = (
        graph(
            [("s", 1, "x"), ("x", 2, "y"), ("s", 2, "z"), ("z", 1, "y")],
            {"x": "a", "z": "a", "y": "b"},
            ["F a", "F b"],
            {"kind": "expression", "expression": "max(phi1, phi2) - min(phi1, phi2)"},
        ),
        [(3, 1)],
    )
    assert judge.exact_front(problem, max_cost=50) == points
    planned = from_dict(problem.scenario()).problem()
    assert planned.measure.contract == "additive"
    assert [(plan.cost, plan.preference) for plan in Planner(planned).front()] == points


def relaxed(formula: str, name: str, assume: str = "", when: str = "", price: int = 0) -> judge.JudgedTask:
    """Return a task with at most one relaxation."""
    entries = (judge.Relaxation(assume, judge.parse(when), price),) if assume else ()
    return judge.JudgedTask(name, judge.parse(formula), entries)


@pytest.mark.parametrize(
    ("skip", "points"), [(25, [(50, 77), (60, 30), (64, 15)]), (20, [(50, 67), (60, 30), (64, 15)])]
)
def test_the_front_of_case_study_2(skip: int, points: list[tuple[int, int]]) -> None:
    """The paper's text prices skipping phi5 at 20; the point (50, 77) of its figure takes 25."""
    conflicting = judge.JudgedTask("phi5", judge.parse("(!cheese U pizza) & (!cheese U tacos)"), skip=skip)
    problem = judge.grid_problem(
        (20, 20),
        (0, 0),
        TOWN,
        [
            relaxed("!pizza U cheese", "phi1", "cheese", "grocer", 15),
            relaxed("F(grocer & F(p2))", "phi2"),
            relaxed("F(tacos & F(p3) & F(p4))", "phi3", "p4", "true", 15),
            relaxed("F(pizza & F(p1))", "phi4", "pizza", "tacos", 12),
            conflicting,
        ],
        {
            "kind": "weighted-sum",
            "weights": {"phi1": 1, "phi2": 1, "phi3": 1, "phi4": 1, "phi5": 2},
            "over": "violation",
        },
    )
    front = Planner(from_dict(problem.scenario()).problem()).front()
    assert front.complete
    assert [(plan.cost, plan.preference) for plan in front] == points
    assert not [wrong for plan in front if (wrong := misjudged(problem, plan))]
    cheapest = {(bought.task, bought.assume) for bought in front[0].relaxations}
    assert ("phi5", None) in cheapest
    assert sum(bought.cost for bought in front[0].relaxations) == points[0][1] - skip
