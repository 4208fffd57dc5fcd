"""Scenario files with several costs and several preferences."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from scenario_texts import task_tables

from prefplan import Planner, PrefplanError, ScenarioError, load
from prefplan.scenario.decode import loads

GRID = """
[model]
kind = "grid"
size = [3, 2]
start = [0, 0]
cost = { time = 2, energy = 0.5 }
[model.regions]
goal = [2, 0, 2, 0]
[model.terrain]
mud = { boxes = [1, 0, 1, 0], cost = { energy = 3, time = 1 } }
[[tasks]]
name = "go"
formula = "F goal"
[[preferences]]
name = "soon"
kind = "deadline"
deadlines = { go = { by = 3 } }
[[preferences]]
name = "frugal"
kind = "weighted-sum"
weights = { go = 2 }
of = "energy"
"""

TABLE = """
[model]
kind = "manipulation"
start = "home"
[model.costs]
transit = { time = 3, energy = 9 }
grasp = { time = 1, energy = 1 }
transport = { time = 5, energy = 12 }
release = { time = 1, energy = 0 }
[model.locations]
left = { at = [0.5, 0.1] }
right = { at = [0.5, -0.1] }
[model.objects]
cup = { start = "left" }
""" + task_tables(move="F cup_right", preference="")


def test_a_grid_has_terrain_costs_by_name_and_preferences_in_either_cost() -> None:
    front = Planner(loads(GRID).problem()).front()
    assert [plan.objectives for plan in front] == [
        {"time": 3, "energy": 3.5, "soon": 0, "frugal": 7},
        {"time": 8, "energy": 2, "soon": 5, "frugal": 4},
    ]
    first = front[0]
    assert (first.cost, first.preference, first.task_costs) == (3, 0, {"go": 3})


def test_terrain_may_have_the_only_cost() -> None:
    text = GRID.replace("{ time = 2, energy = 0.5 }", "2").replace("{ energy = 3, time = 1 }", "5")
    system = loads(text).model.transition_system()
    cells = list(system.states)
    assert system.cost_names[0] == "cost"
    assert [system.step(cells.index(cell), "E") for cell in ((0, 0), (1, 0))] == [
        (cells.index((1, 0)), 5),
        (cells.index((2, 0)), 2),
    ]


def test_an_arm_needs_no_preference_where_there_are_two_costs() -> None:
    problem = loads(TABLE).problem()
    assert problem.objective_names == ("time", "energy")
    [plan] = Planner(problem).front()
    assert (plan.objectives, plan.actions) == (
        {"time": 10, "energy": 22},
        ("transit left", "grasp cup", "transport cup right", "release cup right"),
    )


@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [
        (
            GRID,
            "{ energy = 3, time = 1 }",
            "{ energy = 3 }",
            "model.terrain.mud.cost: gives the costs energy, but cost gives the costs time, energy; every cost has the "
            "same names",
        ),
        (
            GRID,
            "{ energy = 3, time = 1 }",
            "3",
            "model.terrain.mud.cost: gives a number (the cost 'cost'), but cost gives the costs time, energy; every "
            "cost has the same names",
        ),
        (GRID, "time = 1", "time = -1", "model.terrain.mud.cost.time: negative cost -1"),
        (GRID, "time = 2", 'time = "2"', "model.cost.time: must be a number, not '2'"),
        (GRID, "[1, 0, 1, 0]", "[1, 0, 9, 0]", "model.terrain.mud: box [1, 0, 9, 0] reaches outside the grid of 3 x 2"),
        (GRID, 'of = "energy"', 'of = "enrgy"', "preferences.frugal.of: unknown cost 'enrgy' (did you mean 'energy'?)"),
        (GRID, 'name = "frugal"', 'name = "soon"', "preferences.soon.name: 'soon' is used twice"),
        (GRID, 'name = "frugal"', 'name = "time"', "preferences.time.name: 'time' is used twice (names so far: time, "),
        (GRID, 'name = "frugal"', "", "preferences[1].name: missing"),
        (GRID, "go = 2", "gone = 2", "preferences.frugal.weights: unknown task 'gone' (did you mean 'go'?)"),
        (
            TABLE,
            "{ time = 1, energy = 1 }",
            "{ time = 1 }",
            "model.costs.grasp: gives the costs time, but costs.transit gives the costs time, energy; every cost has "
            "the same names",
        ),
    ],
)
def test_mistakes_are_named_with_their_place(file: Path, text: str, old: str, new: str, message: str) -> None:
    file.write_text(text.replace(old, new, 1))
    with pytest.raises(ScenarioError, match="^" + re.escape(f"{file}: {message}")):
        load(file).problem()


def test_bounds_hold_for_every_objective_and_an_empty_front_says_why() -> None:
    planner = Planner(loads(GRID).problem())
    assert [plan.cost for plan in planner.front(at_most={"energy": 2})] == [8]
    assert [plan.cost for plan in planner.front(at_most={"soon": 4.5})] == [3]
    assert [plan.cost for plan in planner.front(at_most={"soon": 4, "time": 9})] == [3]
    reason = planner.front(at_most={"frugal": 3}).reason
    assert reason is not None and (reason.kind, reason.smallest) == ("bound", 4)
    assert planner.best("frugal").objectives == {"time": 8, "energy": 2, "soon": 5, "frugal": 4}


def test_a_general_preference_needs_a_bound_on_its_own_cost() -> None:
    text = GRID.replace(
        'kind = "weighted-sum"\nweights = { go = 2 }', 'kind = "expression"\nexpression = "go"\ncontract = "general"'
    )
    planner = Planner(loads(text).problem())
    with pytest.raises(PrefplanError, match="frugal: its contract is 'general'.*--at-most energy=VALUE"):
        planner.front(at_most={"time": 9})
    assert [plan.cost for plan in planner.front(at_most={"energy": 4})] == [3, 8]


RULED = """
[[rules]]
name = "clean"
formula = "G !mire"
skip = 4
[[preferences]]
name = "paid"
kind = "weighted-sum"
weights = { clean = 1 }
over = "violation"
"""


def test_rules_hold_and_may_be_broken_for_a_price_that_a_preference_weighs() -> None:
    text = GRID.replace("goal = [2, 0, 2, 0]", "goal = [2, 0, 2, 0]\nmire = [1, 0, 1, 0]")
    strict = RULED[: RULED.index("skip")]
    assert [list(plan.objectives.values()) for plan in Planner(loads(text + strict).problem()).front()] == [
        [8, 2, 5, 4]
    ]
    front = Planner(loads(text + RULED).problem()).front()
    assert [list(plan.objectives.values()) for plan in front] == [[3, 3.5, 0, 7, 4], [8, 2, 5, 4, 0]]
    assert [(bought.task, bought.cost) for bought in front[0].relaxations] == [("clean", 4)]


def test_an_arm_with_one_cost_may_have_several_preferences() -> None:
    text = TABLE
    for table, number in (("time = 3, energy = 9", 3), ("time = 1, energy = 1", 1), ("time = 5, energy = 12", 5)):
        text = text.replace(f"{{ {table} }}", str(number))
    text = text.replace("{ time = 1, energy = 0 }", "1")
    text += '[[preferences]]\nname = "soon"\nkind = "max"\n[[preferences]]\nname = "first"\nkind = "order"\n'
    [plan] = Planner(loads(text).problem()).front()
    assert plan.objectives == {"cost": 10, "soon": 10, "first": 0}
