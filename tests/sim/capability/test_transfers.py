"""Transfers rehearsed among the objects that stand around: what is refused, and what need not be rehearsed again."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from judge.transfers import fronts

from prefplan.models.feasibility import Transfer
from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from prefplan.models.manipulation.surroundings import Fixture
from prefplan.planner import Planner
from prefplan.preferences.kinds import Order
from prefplan.problem import Problem, Task
from sim.capability.answers import Capability
from sim.capability.attempts import Attempts
from sim.capability.feasibility import Feasibility
from sim.capability.rehearsal import Rehearsal
from sim.capability.transfers import Transfers
from sim.execution.executor import Execution
from sim.skills.catalogue import SKILLS
from sim.world.scene import Scene, build_scene, initial_state

COSTS = {"transit": 3, "grasp": 1, "transport": 5, "release": 1}

SIZES = (0.03, 0.03, 0.05), (0.04, 0.06, 0.09), (0.05, 0.05, 0.03), (0.03, 0.07, 0.06)

BOXES = tuple(Object(f"o{k}", f"p{k}", kind="box", size=size) for k, size in enumerate(SIZES))


def dense(*columns: float) -> Scene:
    """Return a table of eight locations before a wall, with (4,) y, m; usually some objects hinder each other."""
    grid = [(x, y) for x in (0.42, 0.53) for y in columns or (-0.2, -0.09, 0.03, 0.15)]
    places = tuple(Location(f"p{k}", at=at) for k, at in enumerate(grid))
    wall = Fixture("wall", "box", at=(0.62, 0.0, 0.1), size=(0.03, 0.5, 0.2))
    return build_scene(ManipulationModel("home", COSTS, places, BOXES, fixtures=(wall,)))


def random_transfer(rng: random.Random, scene: Scene) -> Transfer:
    places = rng.sample([place.name for place in scene.model.locations], len(BOXES) + 1)
    obj, *others = rng.sample([box.name for box in BOXES], len(BOXES))
    stand = dict(zip(others, places[2:], strict=True))
    return Transfer(obj, places[0], places[1], tuple((box.name, stand[box.name]) for box in BOXES if box.name in stand))


@pytest.mark.slow
def test_what_need_not_be_rehearsed_again_would_succeed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The twin rehearses every transfer."""
    scene, rng, tried = dense(-0.3, -0.14, 0.03, 0.19), random.Random(5), list[Rehearsal]()
    attempts = Attempts(scene, SKILLS)
    attempt, transfers = attempts.attempt, Transfers(attempts)
    monkeypatch.setattr(attempts, "attempt", lambda rehearsal: (tried.append(rehearsal), attempt(rehearsal))[1])
    spared = 0
    for _ in range(20):
        obj, source, target, _ = random_transfer(rng, scene)
        for _ in range(20):
            transfer = random_transfer(rng, scene)
            if {obj, source, target} & {name for pair in transfer.others for name in pair}:
                continue
            transfer, before = transfer._replace(obj=obj, source=source, target=target), len(tried)
            found, rehearsed = transfers.rehearse(transfer), len(tried) > before
            assert (found is None) == (Transfers(attempts).rehearse(transfer) is None), transfer
            spared += not rehearsed
    assert spared >= 5


def test_what_fails_because_of_its_neighbours_is_refused_while_they_are_there() -> None:
    scene = dense()
    arm = Feasibility(scene)
    refused = [arm.rehearse(random_transfer(random.Random(seed), scene)) for seed in range(25)]
    named = [(one, conditions) for one in refused if one for conditions, _ in one.barred]
    assert any(len(conditions - {f"{one.obj}_{one.location}"}) for one, conditions in named)
    for one in filter(None, refused):
        assert one.barred or one.reason


def test_what_would_hinder_a_later_move_is_not_put_in_its_way() -> None:
    """Once a box stands at p4, the hand cannot grasp the other one at p0, which has to be moved before."""
    model = dense().model
    boxes = (replace(BOXES[1], start="p7"), replace(BOXES[3], start="p0"))
    scene = build_scene(replace(model, objects=boxes))
    problem = Problem(scene.model, {"t": "(!o3_p6 U o1_p4) & F o3_p6"}, Order())
    able = Problem(problem.system, problem.tasks, Order(), feasible=Capability(scene.model, scene=scene))
    planner = Planner(able)
    plan = planner.cheapest()
    assert Planner(problem).cheapest().cost == 20 < plan.cost
    assert planner.geometry is not None and ("o3", "p0") in planner.geometry.left_out
    run = Execution(scene, initial_state(scene))
    assert all(run.step(action, ahead=plan.actions[k + 1 :]) for k, action in enumerate(plan.actions)), run.reason


def test_an_object_is_put_on_supports_of_equal_height() -> None:
    spots = {
        "l": (0.45, -0.038),
        "r": (0.45, 0.038),
        "a": (0.45, -0.3),
        "b": (0.55, -0.3),
        "c": (0.45, 0.3),
        "d": (0.6, 0.2),
    }
    places = (*(Location(name, at=at) for name, at in spots.items()), Location("top", on=("l", "r")))
    cubes = {"low": ("a", 0.035), "tall": ("l", 0.05), "low2": ("c", 0.035)}
    plank = Object("plank", "d", kind="box", size=(0.05, 0.118, 0.03))
    objects = (*(Object(name, start, size=(size,)) for name, (start, size) in cubes.items()), plank)
    model = ManipulationModel("home", COSTS, places, objects)
    planner = Planner(Problem(model, {"t": "F plank_top"}, Order(), feasible=Capability(model)))
    assert (Planner(Problem(model, {"t": "F plank_top"}, Order())).cheapest().cost, planner.cheapest().cost) == (20, 40)
    assert planner.geometry is not None
    assert planner.geometry.left_out["plank", "top"].startswith("plank would not rest on low")


def test_a_tilted_hand_comes_in_any_pose_that_is_free_whatever_is_done_next() -> None:
    """Between two walls the first poses over the box are blocked by its neighbour; one of the next is free."""
    places = {"p0": (0.54, -0.06), "p1": (0.54, -0.13), "p3": (0.4, -0.13), "p4": (0.62, 0.15)}
    neighbour = Object("o0", "p0", kind="box", size=(0.03, 0.055, 0.08), fixed=True)
    walls = (
        Fixture("w0", "box", at=(0.435, -0.1, 0.1), size=(0.01, 0.15, 0.2)),
        Fixture("w1", "box", at=(0.505, 0.0, 0.1), size=(0.01, 0.15, 0.2)),
    )
    model = ManipulationModel(
        "home",
        COSTS,
        tuple(Location(name, at=at) for name, at in places.items()),
        (neighbour, replace(neighbour, name="o1", start="p1", fixed=False)),
        fixtures=walls,
    )
    scene = build_scene(model)
    assert Feasibility(scene).check("o1", "p1").take
    found, expected, rehearsed = fronts(scene, [Task("t", "F o1_p4")])
    assert found == expected == [(10, 0)] and rehearsed == 9


def test_what_fails_is_left_out_also_where_it_is_not_known_in_which_slot_an_object_is() -> None:
    """At `a` there are two slots; the jars beside `t` leave no room for the fingers."""
    places = {"t": (0.5, 0.0), "n": (0.5, 0.055), "s": (0.5, -0.055), "f": (0.45, 0.25)}
    jar = Object("j1", "n", kind="cylinder", size=(0.05, 0.1))
    model = ManipulationModel(
        "home",
        COSTS,
        (Location("a", at=(0.45, -0.25), capacity=2), *(Location(name, at=at) for name, at in places.items())),
        (Object("cube", "a"), jar, replace(jar, name="j2", start="s")),
        fixtures=tuple(
            Fixture(f"w{k}", "box", at=(x, 0.0, 0.06), size=(0.01, 0.06, 0.12)) for k, x in enumerate((0.465, 0.535))
        ),
    )
    scene = build_scene(model)
    arm = Capability(model, scene=scene)
    planner = Planner(Problem(model, {"up": "F cube_t"}, Order(), feasible=arm))
    plan = planner.cheapest()
    assert planner.geometry is not None and ("cube", "t") in planner.geometry.left_out
    run = Execution(scene, initial_state(scene))
    assert all(run.step(action, ahead=plan.actions[k + 1 :]) for k, action in enumerate(plan.actions)), run.reason
