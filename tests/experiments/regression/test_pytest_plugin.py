"""The fixtures for pytest, used as by a user who tests their own scenario."""

from __future__ import annotations

import tomllib
from decimal import Decimal
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
import ompl  # noqa: F401  # pytest forgets what tests in its process load first, and this cannot be loaded twice
import pytest
from numba.core.registry import cpu_target
from scenario_texts import PLACES_NEARBY, cup_scenario

from experiments.regression.assertions import assert_completed, assert_front, assert_plan
from experiments.runs import evidence, run_plan  # noqa: F401  # the same
from prefplan import (
    Expression,
    GraphModel,
    NamedPreference,
    Order,
    PrefplanError,
    Problem,
    Task,
    Transition,
    TransitionSystem,
    WeightedSum,
    pareto_front,
)
from prefplan.claims import Claims, judge
from prefplan.exact_costs import Number, exact
from prefplan.ledger import Ledger

cpu_target.target_context.refresh()  # the same, for what Numba loads when it compiles first

pytest_plugins = ["pytester"]

ROOT = Path(__file__).parents[3]

CUP = cup_scenario(costs="{ transit = 3, grasp = 1, transport = 5.5, release = 1 }", places=PLACES_NEARBY)


@pytest.fixture
def reader(pytester: pytest.Pytester) -> pytest.Pytester:
    """A user's folder, in which pytest is started with the plugin and nothing else of this project."""
    pytester.makefile(".toml", cup=CUP)
    # By module, whether or not the package is installed so that its entry point is known.
    # Without what collects garbage for seconds.
    spared = "-p no:cacheprovider -p no:unraisableexception"
    pytester.makeini(f"[pytest]\naddopts = -p no:prefplan -p prefplan.pytest_plugin {spared}")
    return pytester


@pytest.fixture
def problem() -> Problem:
    """Two rooms whose visits add up in thirds."""
    graph = nx.DiGraph()
    graph.add_nodes_from([("hall", {"labels": []}), ("a", {"labels": ["a"]}), ("b", {"labels": ["b"]})])
    for source, target, cost in (("hall", "a", 1), ("a", "b", 3), ("hall", "b", 1), ("b", "a", 3)):
        graph.add_edge(source, target, action=f"go {target}", cost=cost)
    system = TransitionSystem.from_networkx(graph, start="hall")
    return Problem(system, [Task("first", "F b"), Task("second", "F a")], Expression("first / 3 + second"))


def test_the_entry_point_is_the_module_that_has_the_fixtures() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    plugin = import_module(project["entry-points"]["pytest11"]["prefplan"])
    names = {getattr(one, "_fixture_function_marker", None) and one.name for one in vars(plugin).values()}
    assert {"assert_front", "assert_plan", "assert_completed"} <= names


def test_a_point_of_several_costs_has_all_of_them() -> None:
    edges = (
        Transition("s", "t", "ride", {"time": 1, "fare": 2.5}),
        Transition("s", "t", "walk", {"time": 4, "fare": 0}),
    )
    system = GraphModel("s", edges, {"t": ["a"]}).transition_system()
    problem = Problem(system, [Task("go", "F a")], [NamedPreference("soon", Order())])
    assert_front(problem, [(4, 0, 0), (1, 2.5, 0)])
    for points in ([(1, 2.5, 0), (4, 0, 1)], [(1, 2.5), (4, 0)]):
        with pytest.raises(AssertionError, match=r"\+ +\(4, 0, 0\) +plan 1: walk"):
            assert_front(problem, points)


def test_right_outcomes_pass_and_others_are_told(reader: pytest.Pytester) -> None:
    reader.makepyfile(
        """
        from decimal import Decimal

        def test_front(assert_front):
            assert assert_front("cup.toml", [(Decimal("10.5"), 0)])[0].task_costs == {"tidy": 10.5}

        def test_plan(assert_plan):
            actions = ["transit desk", "grasp cup", "transport cup tray", "release cup tray"]
            plan = assert_plan("cup.toml", actions, plan="preference", task_costs={"tidy": 10.5})
            assert plan.cost == 10.5

        def test_another_front(assert_front):
            assert_front("case_study_3", [(34, 17), (40, 2), (41.5, 0)])

        def test_another_plan(assert_plan):
            assert_plan("cup.toml", ["transit desk", "grasp cup", "release cup desk"])

        def test_other_task_costs(assert_plan):
            assert_plan("cup.toml", task_costs={"tidy": 10})
        """
    )
    result = reader.runpytest_inprocess("-q")
    result.assert_outcomes(passed=2, failed=3)
    result.stdout.re_match_lines_random([r"E\s+AssertionError: case_study_3: the front is not the expected one"])
    result.stdout.re_match_lines(
        [
            r"E\s+expected +found",
            r"E\s+\(34, 17\) +\(34, 17\)",
            r"E\s+- \(40, 2\)",
            r"E\s+\+ +\(41, 0\) +plan 1: transit top, grasp pink, .*",
            r"E\s+- \(41.5, 0\)",
        ],
        consecutive=True,
    )
    result.stdout.re_match_lines(
        [
            r"E\s+action 2 is 'transport cup tray', not 'release cup desk'",
            r"E\s+AssertionError: cup: plan 'cost' satisfies tidy at cost 10.5, not 10 \(all: tidy 10.5\)",
        ]
    )
    result.stdout.no_re_match_line(r".*assertions\.py")  # the traceback ends in the reader's own test


@pytest.mark.slow
def test_an_execution_is_asserted_from_what_was_simulated(reader: pytest.Pytester) -> None:
    reader.makepyfile(
        """
        from functools import partial

        import experiments.runs.run_plan
        from sim.execution.faults.miss import Miss

        def test_it_works(assert_completed):
            outcome = assert_completed("cup.toml", seed=1)
            assert outcome.run.placement_error < 0.005

        def test_every_grasp_misses(assert_completed, monkeypatch):
            spoilt = partial(experiments.runs.run_plan.run_plan, faults=[Miss(1, "99")])
            monkeypatch.setattr(experiments.runs.run_plan, "run_plan", spoilt)
            assert_completed("cup.toml", plan="preference", seed=2)
        """
    )
    result = reader.runpytest_inprocess("-q")
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.re_match_lines(
        [
            r"E\s+AssertionError: cup: plan 'preference' was not carried out: stopped .*",
            r"E\s+carried out: transit desk, .*",
            r"E\s+to watch it: prefplan run cup.toml --plan preference --seed 2",
        ]
    )


def test_preference_values_that_are_doubles_may_differ_in_their_last_places(problem: Problem) -> None:
    assert_front("example", [(9, 3), (6, 4)])  # in any order
    (plan,) = assert_front(problem, [(4, 7 / 3 * (1 + 1e-12))])
    assert plan.actions == ("go a", "go b")
    with pytest.raises(AssertionError, match="not the expected one"):
        assert_front(problem, [(4, 2.3333)])


def test_a_problem_is_not_carried_out(problem: Problem) -> None:
    with pytest.raises(PrefplanError, match="needs a scenario"):
        assert_completed(problem)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("cost", "given"),
    [
        (Fraction(1, 3), Fraction(1, 3)),
        (Fraction(1, 3), 1 / 3),
        (Fraction(1, 3), np.float64(1 / 3)),
        (Decimal("0.1"), Fraction(1, 10)),
        (0.1, np.float32(0.1)),
        (np.int64(3), np.float32(3)),
        (2, Decimal("2.0")),
        pytest.param(10**330, 10**330, id="beyond floats"),
    ],
)
def test_a_value_may_be_given_as_any_kind_of_number(cost: Number, given: Number) -> None:
    system = TransitionSystem.from_transitions([("s", "go", "t", cost)], start="s", labels={"t": ["a"]})
    problem = Problem(system, [Task("go", "F a", skip=cost)], WeightedSum({"go": 1}, over="violation"))
    paid, gone = assert_front(problem, [(0, given), (given, 0)])
    assert_plan(problem, task_costs={"go": 0}, plan="cost")
    assert_plan(problem, task_costs={"go": given}, plan="preference")
    with pytest.raises(AssertionError, match="not the expected one"):
        assert_front(problem, [(0, given), (exact(given) * Fraction(10**12 + 1, 10**12), 0)])
    for plan in (paid, gone):
        claims = Claims(True, plan.cost, plan.task_costs, plan.violation_costs, plan.preference, plan.relaxations)
        ledger = Ledger.of_plan(problem, plan)
        verdict = judge(claims, problem.tasks, problem.preference, ledger.labels, ledger.costs)
        assert [check for check in verdict.checks if not check.holds] == []


def test_the_reason_why_there_is_no_plan_is_told() -> None:
    graph = nx.DiGraph()
    graph.add_edge("hall", "hall", action="stay", cost=1)
    system = TransitionSystem.from_networkx(graph, start="hall", propositions=["a"])
    stuck = Problem(system, [Task("visit", "F a")], Order())
    assert len(assert_front(stuck, [])) == 0
    with pytest.raises(AssertionError, match="task visit can never be satisfied"):
        assert_front(stuck, [(1, 0)])


def test_an_assertion_about_nothing_is_refused(problem: Problem) -> None:
    with pytest.raises(PrefplanError, match="neither which actions nor which task_costs"):
        assert_plan(problem)
    with pytest.raises(PrefplanError, match="no task 'third', only first, second"):
        assert_plan(problem, task_costs={"third": 1})
    with pytest.raises(PrefplanError, match=r"actions: must be a list, such as \[.north.\], not text"):
        assert_plan(problem, "north")


@pytest.mark.parametrize("points", [None, [18, 19], {18: 19}, "18"])
def test_what_are_no_points_is_refused_in_a_sentence(problem: Problem, points: Any) -> None:
    with pytest.raises(PrefplanError, match=r"points: must be a list such as \[\(COST, PENALTY\), ...\], not "):
        assert_front(problem, points)


def test_a_front_is_no_problem(problem: Problem) -> None:
    with pytest.raises(PrefplanError, match="must be a Problem, a scenario, or the name or path of one, not a Front"):
        assert_front(pareto_front(problem), [])  # type: ignore[arg-type]
