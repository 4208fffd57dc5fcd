"""What a failed action excludes from later plans."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from prefplan import Order, Problem, Task
from prefplan.models.manipulation.model import Location, ManipulationModel, ManipulationState, Object
from prefplan.models.manipulation.symbolic import Action
from prefplan.planner import Planner
from prefplan.replanning import continue_cheaply
from sim.errors import BlockedError, SimulationError
from sim.execution.closed_loop import ClosedLoop
from sim.execution.executor import Execution
from sim.execution.failures import Failures
from sim.perception.sensors import ExactSensor, ObjectPose
from sim.simulation.kinematic_cell import KinematicCell
from sim.simulation.workcell import Workcell
from sim.skills.catalogue import SKILLS
from sim.skills.grasp import GraspSkill
from sim.skills.transit import TransitSkill
from sim.world.scene import Scene, build_scene, initial_state


class ShortArm(TransitSkill):
    """Does not reach the location `far`, which no rehearsal shows."""

    def perform(self, cell: Workcell, action: Action, ahead: Sequence[Action] = ()) -> None:
        if action.location == "far" and not isinstance(cell, KinematicCell):
            raise SimulationError("out of reach")
        super().perform(cell, action, ahead)


class Walled(TransitSkill):
    """A wall keeps the hand from the location `far`, in rehearsals, too."""

    def perform(self, cell: Workcell, action: Action, ahead: Sequence[Action] = ()) -> None:
        if action.location == "far":
            raise BlockedError.on_the_way({"wall"})
        super().perform(cell, action, ahead)


@pytest.mark.parametrize("skill", [ShortArm(), Walled()])
def test_a_place_out_of_reach_is_not_tried_again_after_moving_objects_that_do_not_matter(skill: TransitSkill) -> None:
    at = {"far": (0.6, 0.25), "beside": (0.52, 0.17), "here": (0.45, -0.2), "there": (0.55, -0.3), "rest": (0.4, 0.1)}
    costs = {"transit": 3, "grasp": 1, "transport": 5, "release": 1}
    objects = Object("cup", "far"), Object("low", "beside"), Object("box", "here")
    model = ManipulationModel("home", costs, tuple(Location(name, at=point) for name, point in at.items()), objects)
    problem = Problem(model.transition_system(), [Task("cup", "F cup_rest"), Task("box", "F box_there")], Order())
    scene = build_scene(model)
    run = Execution(scene, initial_state(scene), skills=SKILLS | {"transit": skill})
    ClosedLoop(run, problem, Planner(problem).cheapest(), go_on=continue_cheaply).run()
    actions = [step.action for step in run.steps]
    assert actions.count("transit far") == 1 and actions[-1] == "release box there"


def test_of_what_hinders_a_grasp_few_are_named_where_objects_are_observed() -> None:
    around = {"ahead": (0.58, 0.0), "back": (0.42, 0.0), "left": (0.5, 0.08), "right": (0.5, -0.08)}
    places = tuple(Location(name, at=point) for name, point in (around | {"middle": (0.5, 0.0)}).items())
    costs = {"transit": 3, "grasp": 1, "transport": 5, "release": 1}
    posts = (Object(name, name, kind="box", size=(0.04, 0.04, 0.1)) for name in around)
    model = ManipulationModel("home", costs, places, (Object("cup", "middle"), *posts))
    scene = build_scene(model)
    data = initial_state(scene)
    for name in around:  # nearer to the cup, but still at their locations
        data.joint(name).qpos[:2] += 0.3 * (np.array([0.5, 0.0]) - around[name])
    mujoco.mj_forward(scene.mujoco, data)
    run = Execution(scene, data)
    assert run.step("transit middle")
    assert not run.step("grasp cup")
    assert run.blocked and set() < set(around) & set(run.blocked) < set(around)


def test_a_place_out_of_reach_is_not_barred_for_good_where_what_is_there_was_not_known() -> None:
    at = {"far": (0.6, 0.25), "rest": (0.4, 0.1), "here": (0.45, -0.2)}
    costs = {"transit": 3, "grasp": 1, "transport": 5, "release": 1}
    places = tuple(Location(name, at=point) for name, point in at.items())
    model = ManipulationModel("home", costs, places, (Object("cup", "far"), Object("box", "here")))
    scene = build_scene(model)
    run = Execution(scene, initial_state(scene), skills=SKILLS | {"transit": ShortArm()})
    assert not run.step("transit far") and run.blocked == ()
    state, failures = run.reground(), Failures()
    failures.record(run, [replace(state, places=(("box", "here"),))])
    assert {bars for bars, _ in failures.barred} == {frozenset({"cup_far"}), frozenset({"box_here"})}


class Stuck(GraspSkill):
    """A wall keeps the hand from raising what it has grasped."""

    def perform(self, cell: Workcell, action: Action, ahead: Sequence[Action] = ()) -> None:
        super().perform(cell, action, ahead)
        raise BlockedError.on_the_way({"wall"})


def test_what_is_grasped_and_cannot_be_raised_is_not_grasped_again_there() -> None:
    places = Location("here", at=(0.5, 0.1)), Location("rest", at=(0.4, -0.1))
    costs = {"transit": 3, "grasp": 1, "transport": 5, "release": 1}
    model = ManipulationModel("home", costs, places, (Object("cup", "here"),))
    scene = build_scene(model)
    run, failures = Execution(scene, initial_state(scene), skills=SKILLS | {"grasp": Stuck()}), Failures()
    before = [run.reground()]
    assert run.step("transit here")
    before.append(run.reground())
    assert not run.step("grasp cup") and run.steps[-1].observed.held == "cup"
    failures.record(run, before)
    assert {action for _, action in failures.excluded} == {"grasp cup"}
    model.transition_system().without(failures.excluded)


class Camera(ExactSensor):
    """Sees nothing once it is broken."""

    broken = False

    def observe(self, scene: Scene, data: mujoco.MjData, obj: str) -> ObjectPose | None:
        """See `Sensor`."""
        return None if Camera.broken else super().observe(scene, data, obj)


def test_a_sensor_that_fails_when_it_is_asked_what_raised_the_hand_ends_the_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    places = Location("far", at=(0.6, 0.25)), Location("rest", at=(0.4, 0.1))
    costs = {"transit": 3, "grasp": 1, "transport": 5, "release": 1}
    model = ManipulationModel("home", costs, places, (Object("cup", "far"),))
    problem = Problem(model.transition_system(), [Task("cup", "F cup_rest")], Order())
    scene = build_scene(model)
    run = Execution(scene, initial_state(scene), sensor=Camera(), skills=SKILLS | {"transit": ShortArm()})
    reground = run.reground

    def last() -> ManipulationState:
        state = reground()
        monkeypatch.setattr(Camera, "broken", True)
        return state

    monkeypatch.setattr(run, "reground", last)
    ClosedLoop(run, problem, Planner(problem).cheapest(), go_on=continue_cheaply).run()
    assert run.reason and "nothing has been seen of cup" in run.reason


def test_of_what_is_in_the_way_few_are_named_that_block_all_candidates_and_fixtures_first() -> None:
    collisions = [{"wall", "cup"}, {"cup", "jar"}, {"jar", "mug"}]
    error = BlockedError.beside_fingers(collisions, movable={"cup", "jar", "mug"})
    assert error.by == ("jar", "wall") and error.collisions == collisions
