"""What a user may give for a problem, a transition system, tasks and rules."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import networkx as nx
import pytest
from scenario_texts import GRID

import prefplan as pp

PLANNERS: dict[str, Callable[[pp.Problem | pp.Scenario | str | Path], list[pp.Plan]]] = {
    "pareto_front": lambda given: list(pp.pareto_front(given)),
    "cheapest_plan": lambda given: [pp.cheapest_plan(given)],
    "preferred_plan": lambda given: [pp.preferred_plan(given)],
    "best_plan": lambda given: [pp.best_plan(given, "preference")],
    "Planner": lambda given: list(pp.Planner(given).front()),
}


@pytest.mark.parametrize("name", PLANNERS)
def test_a_problem_may_be_a_scenario_or_its_name_or_path(name: str, file: Path) -> None:
    file.write_text(GRID)
    find, scenario = PLANNERS[name], pp.load(file)
    plans = find(scenario.problem())
    assert plans
    assert find(scenario) == find(file) == find(str(file)) == plans
    assert find("example") == find(pp.load("example").problem())


def test_a_ledger_takes_a_scenario() -> None:
    plan = pp.cheapest_plan("example")
    assert pp.Ledger.of_plan("example", plan).final == pp.Ledger.of_plan(pp.load("example").problem(), plan).final


def test_a_scenario_that_ships_is_loaded_by_its_name_without_the_programs(tmp_path: Path) -> None:
    # Another package of the same name in the working directory is no obstacle.
    (tmp_path / "experiments").mkdir()
    (tmp_path / "experiments" / "__init__.py").write_text("raise RuntimeError")
    script = "import sys, prefplan; print(prefplan.load('case_study_3').name, 'experiments' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (done.stdout, done.stderr) == ("case_study_3 False\n", "")


@pytest.fixture
def aisle() -> nx.DiGraph:
    """A dock and a shelf, and a road of cost 3 in either direction."""
    graph = nx.DiGraph()
    for place in ("dock", "shelf"):
        graph.add_node(place, labels=[place])
    graph.add_edge("dock", "shelf", cost=3)
    graph.add_edge("shelf", "dock", cost=3)
    return graph


TASKS = {"stock": "F shelf", "home": "F (shelf & F dock)"}


def test_a_problem_takes_a_graph_with_its_start_and_formulas_by_name(aisle: nx.DiGraph) -> None:
    problem = pp.Problem(aisle, TASKS, pp.Order(), start="dock", rules={"stay": "G (dock | shelf)"})
    system = pp.TransitionSystem.from_networkx(aisle, start="dock")
    written = [pp.Task("stock", "F shelf"), pp.Task("home", "F (shelf & F dock)")]
    long = pp.Problem(system, written, pp.Order(), rules=[pp.Rule("stay", "G (dock | shelf)")])
    assert (problem.tasks, problem.rules) == (long.tasks, long.rules)
    assert list(pp.pareto_front(problem)) == list(pp.pareto_front(long))
    assert [plan.cost for plan in pp.pareto_front(problem)] == [6]


def test_the_start_of_a_graph_may_be_its_attribute(aisle: nx.DiGraph) -> None:
    again = pp.TransitionSystem.from_networkx(aisle, start="shelf").to_networkx()
    assert pp.cheapest_plan(pp.Problem(again, {"leave": "F dock"}, pp.Order())).actions == ("dock",)
    given = pp.Problem(again, {"leave": "F dock"}, pp.Order(), start="dock")
    assert pp.cheapest_plan(given).actions == ()


def test_a_problem_takes_a_model() -> None:
    model = pp.GridModel(size=(3, 1), start=(0, 0), regions={"goal": [(2, 0, 2, 0)]})
    assert pp.cheapest_plan(pp.Problem(model, {"go": "F goal"}, pp.Order())).actions == ("E", "E")
