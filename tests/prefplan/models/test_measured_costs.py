"""Costs that depend on the hand's pose, and the file of measurements from which they are read."""

from __future__ import annotations

import json
import random
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any, cast

import judge
import pytest
from scenario_texts import task_tables

from prefplan import (
    ManipulationModel,
    ManipulationState,
    ModelError,
    Order,
    Problem,
    ScenarioError,
    cheapest_plan,
    load,
    pareto_front,
)
from prefplan.models.manipulation.action_costs import MeasuredCosts, Pair
from prefplan.models.manipulation.measured_costs import (
    Measurement,
    Measurements,
    geometry,
    measurements_file,
    read_measurements,
    to_json,
)
from prefplan.models.manipulation.model import Location, Object

UNIT = {"transit": 3, "grasp": 1, "transport": 5, "release": 1}

PLACES = {"desk": (0.45, 0.0), "tub": (0.45, 0.3), "tray": (0.45, -0.3)}

SCENARIO = """
[model]
kind = "manipulation"
start = "home"
costs = { measured = "energy" }
[model.locations]
desk = { at = [0.45, 0.0] }
tub = { at = [0.45, 0.3], marks = "clean" }
tray = { at = [0.45, -0.3], kind = "bin" }
[model.objects]
cup = { start = "desk", rgba = [0.5, 0.5, 0.5, 1] }
""" + task_tables(tidy="F cup_tray")


def pairs(*places: str, start: str = "home") -> list[Pair]:
    """Return every action between places: the hand leaves the start pose and never returns to it."""
    moves = [("transit", a, b) for a in (start, *places) for b in places if a != b]
    moves += [("transport", a, b) for a in places for b in places if a != b]
    return moves + [(kind, a, a) for kind in ("grasp", "release") for a in places]


def table(*places: str, seed: int = 0) -> dict[Pair, Decimal]:
    """Return a measured cost with three decimals for every action."""
    rng = random.Random(seed)
    return {pair: Decimal(rng.randint(500, 9999)).scaleb(-3) for pair in pairs(*places)}


def model(costs: Any, *objects: Object, extra: tuple[Location, ...] = ()) -> ManipulationModel:
    places = tuple(Location(name, at=at) for name, at in PLACES.items())
    return ManipulationModel("home", costs, places + extra, objects or (Object("cup", "desk"),))


def spent(what: ManipulationModel, *actions: str, start: ManipulationState | None = None) -> list[int | float]:
    """Return the cost of each action."""
    system = replace(what, begin=start).transition_system().listed
    state, costs = system.start, []
    for action in actions:
        state, cost = system.step(state, action)
        costs.append(cost)
    return costs


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    path = tmp_path / "cup.toml"
    path.write_text(SCENARIO)
    return path


def write(scenario: Path, entries: dict[Pair, Decimal]) -> dict[str, Any]:
    """Write measurements beside a scenario, its energy as given, and return the file's contents."""
    done = tuple(Measurement(pair, {"time": 1, "travel": 2, "energy": cost}, 3) for pair, cost in entries.items())
    what = cast(ManipulationModel, load(scenario, measured=False).model)
    contents = to_json(what, Measurements(done, "skills"))
    measurements_file(scenario).write_text(json.dumps(contents))
    return contents


def test_an_action_costs_what_was_measured_between_its_places() -> None:
    entries = table(*PLACES)
    actions = ("transit desk", "grasp cup", "transport cup tub", "release cup tub", "transit tray")
    expected = [
        entries["transit", "home", "desk"],
        entries["grasp", "desk", "desk"],
        entries["transport", "desk", "tub"],
        entries["release", "tub", "tub"],
        entries["transit", "tub", "tray"],
    ]
    assert spent(model(MeasuredCosts("energy", entries)), *actions) == [float(cost) for cost in expected]


def test_what_could_not_be_measured_is_left_out_and_told() -> None:
    entries = table(*PLACES)
    failed = {("transport", "desk", "tray"): "a wall", ("transit", "home", "tub"): "a wall"}
    left = {pair: cost for pair, cost in entries.items() if pair not in failed}
    whole, without = (model(MeasuredCosts("energy", each, why)) for each, why in ((entries, {}), (left, failed)))
    plans = [cheapest_plan(Problem(each, {"serve": "F cup_tray"}, Order())) for each in (whole, without)]
    assert [sum(action.startswith("transport") for action in plan.actions) for plan in plans] == [1, 2]
    note = "Not measured, and left out: transport from 'desk' to 'tray' (a wall); 1 more."
    assert pareto_front(Problem(without, {"serve": "F cup_tray"}, Order())).assumptions == (note,)
    for listed_states in (0, 9999):
        system = replace(without, listed_states=listed_states).transition_system()
        with pytest.raises(ModelError, match="action 'transit tub' does not exist in state"):
            system.step(system.start, "transit tub")


def test_where_nothing_could_be_measured_no_other_place_stands_in() -> None:
    entries = table(*PLACES)
    failed = {pair: "a wall" for pair in entries if "tub" in pair}
    left = {pair: cost for pair, cost in entries.items() if pair not in failed}
    front = pareto_front(Problem(model(MeasuredCosts("energy", left, failed)), {"soak": "F cup_tub"}, Order()))
    assert not front and front.reason


def test_where_something_fell_costs_what_the_nearest_place_does() -> None:
    entries = table(*PLACES)
    fallen = Location("fallen", at=(0.40, 0.25), closed=True)
    what = model(MeasuredCosts("energy", entries), Object("cup", "fallen"), extra=(fallen,))
    actions = ("transit fallen", "grasp cup", "transport cup tray", "release cup tray", "transit fallen")
    assert spent(what, *actions) == [
        float(entries[pair])
        for pair in (
            ("transit", "home", "tub"),
            ("grasp", "tub", "tub"),
            ("transport", "tub", "tray"),
            ("release", "tray", "tray"),
            ("transit", "tray", "tub"),
        )
    ]


def test_from_the_place_nearest_to_it_the_next_nearest_stands_in() -> None:
    entries = table(*PLACES)
    fallen = Location("fallen", at=(0.45, 0.25), closed=True)
    what = model(MeasuredCosts("energy", entries), Object("cup", "fallen"), extra=(fallen,))
    # The nearest place is the tub itself. The hand is 5 cm from it, and the desk 25 cm from the cup.
    assert spent(what, "transit tub", "transit fallen")[1] == float(entries["transit", "tub", "desk"])


def test_a_hand_over_no_location_is_as_good_as_at_the_start_pose() -> None:
    entries = table(*PLACES)
    adrift = ManipulationState("no location", None, (("cup", "desk"),))
    what = model(MeasuredCosts("energy", entries))
    assert spent(what, "transit tray", start=adrift) == [float(entries["transit", "home", "tray"])]


def test_a_scenario_plans_with_what_was_measured(scenario: Path) -> None:
    entries = table(*PLACES)
    write(scenario, entries)
    (plan,) = pareto_front(load(scenario).problem())
    path = [("transit", "home", "desk"), ("grasp", "desk", "desk"), ("transport", "desk", "tray"), ("release", "tray")]
    direct = sum(entries[cast(Pair, step if len(step) == 3 else (*step, step[-1]))] for step in path)
    assert judge.exact(plan.cost) <= Fraction(direct)
    timed = scenario.with_name("cup.toml")
    timed.write_text(SCENARIO.replace('"energy"', '"travel"'))
    assert pareto_front(load(timed).problem())[0].cost == 8


def test_what_is_written_is_read(scenario: Path) -> None:
    entries = table(*PLACES)
    write(scenario, entries)
    what = cast(ManipulationModel, load(scenario, measured=False).model)
    done = read_measurements(measurements_file(scenario), what)
    assert {one.pair: one.quantities["energy"] for one in done.actions} == entries
    assert [one.pair[0] for one in done.actions] == sorted((one.pair[0] for one in done.actions), key=what.kinds.index)
    assert done.sources == "skills"


def refusal(scenario: Path) -> str:
    with pytest.raises(ScenarioError) as error:
        load(scenario)
    return str(error.value)


def test_costs_that_were_never_measured_are_refused_with_what_to_do(scenario: Path) -> None:
    assert refusal(scenario) == (
        f"{scenario}: model.costs.measured: nothing was measured yet; "
        "`prefplan measure` with this scenario makes cup.measured.json"
    )


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("tub = { at = [0.45, 0.3]", "tub = { at = [0.45, 0.31]"),
        ("tray = {", "shelf = { at = [0.6, 0.1] }\ntray = {"),
        ("cup = { ", "jug = { start = 'tub' }\ncup = { "),
        ('start = "home"', 'start = "desk"'),
        (
            "[model.loc",
            "[model.fixtures]\nwall = { kind = 'box', at = [0.7, 0, 0.1], size = [0.1, 0.1, 0.2] }\n[model.loc",
        ),
        ("[model.loc", "[model.robot]\nat = [0, 0.05]\n[model.loc"),
        ('start = "home"', 'start = "home"\nrobot = "panda_suction"'),
    ],
)
def test_measurements_of_another_geometry_are_refused(scenario: Path, old: str, new: str) -> None:
    write(scenario, table(*PLACES))
    scenario.write_text(SCENARIO.replace(old, new))
    assert "the measurements were made with other locations, objects or surroundings; `prefplan measure`" in refusal(
        scenario
    )


def test_colours_tasks_and_numbers_in_place_of_measurements_change_nothing(scenario: Path) -> None:
    write(scenario, table(*PLACES))
    scenario.write_text(SCENARIO.replace("[0.5, 0.5, 0.5, 1]", "[0.1, 0.5, 0.5, 1]").replace("cup_tray", "cup_tub"))
    assert load(scenario).problem().system.listed.size > 1
    what = cast(ManipulationModel, load(scenario).model)
    assert geometry(what) == geometry(replace(what, costs=UNIT))
    assert geometry(what) != geometry(replace(what, robot="menagerie"))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": 4}, "is damaged"),
        ({"format": "3"}, "is damaged"),
        ({"format": None}, "is damaged"),
        ({"robot": "menagerie"}, "were made with other locations, objects or surroundings"),
        ({"actions": [{"action": "transit"}]}, "is damaged"),
        ({"files": 3}, "is damaged"),
        ({"files": {"lab.xml": "00"}}, "the measurements were made with another lab.xml; `prefplan measure`"),
        ({"actions": [{"action": "grasp", "from": "tub", "to": "tub", "energy": "many"}]}, "is damaged"),
    ],
)
def test_contents_that_do_not_fit_are_refused(scenario: Path, change: dict[str, Any], message: str) -> None:
    contents = write(scenario, table(*PLACES))
    measurements_file(scenario).write_text(json.dumps(contents | change))
    assert message in refusal(scenario)


def test_an_older_file_is_refused_with_what_to_do(scenario: Path) -> None:
    contents = write(scenario, table(*PLACES))
    del contents["format"]
    measurements_file(scenario).write_text(json.dumps(contents))
    assert refusal(scenario) == (
        f"{scenario}: model.costs.measured: the measurements were made by an older version of prefplan; "
        "`prefplan measure` with this scenario makes cup.measured.json again"
    )


def test_an_action_that_was_measured_twice_is_damage(scenario: Path) -> None:
    contents = write(scenario, table(*PLACES))
    failed = [{key: contents["actions"][0][key] for key in ("action", "from", "to")} | {"reason": "a wall"}]
    for change in ({"actions": [*contents["actions"], contents["actions"][3]]}, {"failed": failed}):
        measurements_file(scenario).write_text(json.dumps(contents | change))
        assert "is damaged" in refusal(scenario)


@pytest.mark.parametrize("damage", ["", "[]", "{}", "[" * 100_000])
def test_a_damaged_file_is_refused(scenario: Path, damage: str) -> None:
    measurements_file(scenario).write_text(damage)
    assert "model.costs.measured: the file of measurements" in refusal(scenario)


def test_negative_measurements_are_refused(scenario: Path) -> None:
    write(scenario, table(*PLACES) | {("grasp", "tub", "tub"): Decimal(-1)})
    assert "model.costs.measured: grasp at 'tub': negative cost -1" in refusal(scenario)


@pytest.mark.parametrize(
    ("costs", "message"),
    [
        ('{ measured = "energie" }', "model.costs.measured: unknown quantity 'energie' (did you mean 'energy'?)"),
        ('{ measured = "energy", grasp = 1 }', "model.costs.grasp: unknown key (valid: measured)"),
        ("{ measured = 3 }", "model.costs.measured: must be a string, not 3"),
    ],
)
def test_costs_are_read_strictly(scenario: Path, costs: str, message: str) -> None:
    scenario.write_text(SCENARIO.replace('{ measured = "energy" }', costs))
    assert refusal(scenario) == f"{scenario}: {message}"
