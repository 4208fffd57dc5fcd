"""Feasibility of objects at locations: what is refused works once the scene is changed as the reason says."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scenario_texts import CORNER, shipped

from prefplan.errors import ModelError
from prefplan.models.feasibility import Transfer
from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from prefplan.models.manipulation.surroundings import Fixture
from prefplan.planner import Planner
from prefplan.preferences.kinds import Order
from prefplan.problem import Problem
from prefplan.scenario.decode import loads
from sim.capability.answers import Capability
from sim.capability.arrangement import allowed_places, arranged
from sim.capability.feasibility import Feasibility
from sim.capability.place_check import PlaceCheck
from sim.capability.rehearsal import BROUGHT, Rehearsal, culprits
from sim.errors import BlockedError, SimulationError
from sim.execution.executor import Execution
from sim.motion.kinematics import Arm
from sim.motion.trajectory import ToolPose
from sim.robots.arms.panda import PANDA
from sim.simulation.kinematic_cell import KinematicCell
from sim.skills.hand import free_pose
from sim.skills.skill import NoSpaceError
from sim.world.grasps import ranked
from sim.world.scene import Scene, build_scene, initial_state

COSTS = {"transit": 1, "grasp": 1, "transport": 1, "release": 1}

POST = Fixture("post", "box", at=(0.9, 0.11, 0.02), size=(0.3, 0.02, 0.04))
"""A low wall: an object beside an obstacle is not refused without a trial."""


CUP = Object("cup", "here")


def check_cup(at: tuple[float, ...], *fixtures: Fixture, cup: Object = CUP) -> PlaceCheck:
    """Return the check of a suction cup, which has few grasps, with the object `cup` at its start."""
    places = (Location("here", at=at),)
    model = ManipulationModel("home", COSTS, places, (cup,), fixtures=fixtures, robot="panda_suction")
    return Feasibility(build_scene(model)).check("cup", "here")


def missing(found: PlaceCheck, words: str) -> float:
    """Return the distance, m, in a reason, which must be of the expected form."""
    match = re.fullmatch(words, found.reason or "")
    assert match is not None and not found.take, found.reason
    return int(match[1]) / 100


def test_a_place_out_of_reach_is_told_with_the_distance_that_is_missing() -> None:
    short = missing(check_cup((0.83, 0.0), POST), r"out of reach by (\d+) cm")
    assert check_cup((0.83 - short - 0.01, 0.0), POST) == PlaceCheck("cup", "here")


@pytest.mark.parametrize("distance", [0.105, 0.22, 0.23, 0.25, 0.26, 0.28, 0.31])
def test_a_place_near_the_base_is_tried_not_refused_by_its_distance(distance: float) -> None:
    places = (Location("near", at=(distance, 0.0)), Location("far", at=(0.5, 0.2)))
    scene = build_scene(ManipulationModel("home", COSTS, places, (Object("cube", "far"),)))
    assert Feasibility(scene).check("cube", "near") == PlaceCheck("cube", "near")


def test_where_an_object_fits_in_no_grasp_it_is_not_brought(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[str] = []
    run = Rehearsal.run

    def noted(rehearsal: Rehearsal, *args: Any) -> tuple[int, SimulationError | None]:
        tried.extend(rehearsal.actions)
        return run(rehearsal, *args)

    monkeypatch.setattr(Rehearsal, "run", noted)
    places = Location("far", at=(0.87, 0.0)), Location("near", at=(0.5, 0.2)), Location("other", at=(0.6, -0.2))
    model = ManipulationModel("home", COSTS, places, (Object("cup", "near"),), robot="panda_suction")
    found = Feasibility(build_scene(model)).check("cup", "far")
    assert (found.take, found.put) == (False, False) and "out of reach" in str(found.reason)
    assert not any(action.startswith("transport") for action in tried)


def test_a_place_too_near_the_base_is_told_with_the_distance_that_is_missing() -> None:
    can = Object("cup", "here", kind="cylinder", size=(0.04, 0.14))
    short = missing(check_cup((0.2, 0.0), cup=can), r"too near to the robot's base by (\d+) cm")
    assert check_cup((0.2 + short + 0.005, 0.0), cup=can) == PlaceCheck("cup", "here")


@pytest.mark.filterwarnings("error")
def test_a_place_within_the_base_is_refused_without_a_warning() -> None:
    places = (Location("within", at=(0.0, 0.0)), Location("far", at=(0.5, 0.2)))
    scene = build_scene(ManipulationModel("home", COSTS, places, (Object("cube", "far"),)))
    assert not Feasibility(scene).check("cube", "within").put


def test_a_board_that_is_too_low_is_told_with_the_height_that_is_missing() -> None:
    def shelf(board: float) -> Fixture:
        size = (0.24, 0.5, board + 0.2)
        return Fixture("shelf", "shelf", at=(0.62, 0.28, 0.0), size=size, yaw=180, boards=(0.0, board))

    low = missing(check_cup((0.55, 0.28), shelf(0.44)), r"shelf above too low for the hand by (\d+) cm")
    assert check_cup((0.55, 0.28), shelf(0.44 + low + 0.01)).reason is None


def test_neighbours_that_leave_no_room_for_the_fingers_are_told_with_the_distance_that_is_missing() -> None:
    def check(y: float) -> PlaceCheck:
        beside = {"b": (0.5, 0.055), "d": (0.555, 0.0), "e": (0.445, 0.0)}
        places = [Location("a", at=(0.5, y)), *(Location(name, at=at) for name, at in beside.items())]
        objects = tuple(Object(f"in_{place.name}", place.name) for place in places)
        scene = build_scene(ManipulationModel("home", COSTS, tuple(places), objects))
        return Feasibility(scene).check("in_a", "a")

    found = check(0.0)
    match = re.fullmatch(
        r"no room for the fingers: they would touch in_b .*, (\d\.\d) cm too close", found.reason or ""
    )
    assert match is not None and found.take, found.reason  # a plan may move the others first
    beside = {f"in_{name}_{name}" for name in "bde"}
    [(conditions, action)] = found.barred
    # Of those beside it in the other closing direction, one that stays is enough.
    assert action == "grasp in_a" and {"in_a_a", "in_b_b"} <= conditions < {"in_a_a", *beside}
    assert check(-float(match[1]) / 100).reason is None


@pytest.mark.parametrize("slots", [1, 2])
def test_what_does_not_fit_beside_another_object_is_excluded_while_that_one_stands_there(slots: int) -> None:
    """Boxes there point so that they are wide where they are near to each other, and neither fits beside the other.

    Where there are two slots it is not known in which of them the other object will stand.
    """
    box, post = Object("box", "here", kind="box", size=(0.05, 0.09, 0.05)), Object("post", "x", size=(0.04,))
    beside = Location("x", at=(0.57, 0.1)), Location("y", at=(0.5, 0.16), capacity=slots)
    places = Location("here", at=(0.5, -0.2)), Location("a", at=(0.5, 0.1)), *beside
    model = ManipulationModel("home", COSTS, places, (box, replace(box, name="other", start="y"), post))
    answer = Feasibility(build_scene(model)).check("box", "a")
    words = r"to put it there: no room for box on a: other is \d\.\d cm too close"
    assert re.fullmatch(words, answer.reason or "") and answer.put, "a plan may move it first"
    assert {(*conditions, action) for conditions, action in answer.barred} == {
        (neighbour, "release box a") for neighbour in ("other_x", *["other_y", "post_y"] * (slots == 1))
    }


def test_what_cannot_be_brought_from_its_start_may_be_brought_from_elsewhere() -> None:
    """Above the board the box is held so that the hand would have to point down far away; not so on the table."""
    shelf = Fixture("shelf", "shelf", at=(0.62, 0.3, 0.0), size=(0.24, 0.5, 0.481), yaw=180, boards=(0.0, 0.281))
    wall = Fixture("wall", "box", at=(0.238, 0.28, 0.24), size=(0.04, 0.12, 0.48), yaw=48)
    box = Object("box", "high", kind="box", size=(0.031, 0.073, 0.095), mass=0.535)
    places = Location("high", at=(0.55, 0.3, 0.281)), Location("table", at=(0.293, 0.584))
    model = ManipulationModel(
        "home",
        COSTS,
        (*places, Location("far", at=(0.368, 0.726))),
        (box, Object("cube", "table", size=(0.04,))),
        fixtures=(shelf, wall),
    )
    answer = Feasibility(build_scene(model)).check("box", "far")
    assert "from high: the arm cannot point down" in (answer.reason or "")
    assert answer.barred == [({"box from high"}, "release box far")]


def test_what_can_be_grasped_at_its_start_only_to_be_put_back_goes_nowhere_directly() -> None:
    shelf = Fixture("shelf", "shelf", at=(0.62, -0.3, 0.0), size=(0.24, 0.5, 0.459), yaw=180, boards=(0.0, 0.259))
    wall = Fixture("wall", "box", at=(0.245, -0.067, 0.075), size=(0.03, 0.25, 0.15), yaw=48)
    ends = {"low": (0.55, -0.21), "far": (0.242, -0.498), "near": (0.565, 0.145)}
    places = tuple(Location(name, at=at) for name, at in ends.items())
    box = Object("box", "low", kind="box", size=(0.045, 0.095, 0.035))
    scene = build_scene(ManipulationModel("home", COSTS, places, (box,), fixtures=(shelf, wall)))
    feasibility = Feasibility(scene)
    assert feasibility.check("box", "low").reason is None
    for place in ("far", "near"):
        assert feasibility.check("box", place).not_from == "low"
        assert feasibility.rehearse(Transfer("box", "low", place, ())) is not None


def test_what_is_put_on_a_low_object_is_grasped_there_again() -> None:
    """The box starts below the place, so that what it is put on has to be there first; a tall object could be, too."""
    grid = {f"r{i}c{j}": (0.545 + 0.1455 * i, -0.039 + 0.1455 * j) for i in range(3) for j in range(3)}
    places = *(Location(name, at=at) for name, at in grid.items()), Location("top", on=("r2c1",))
    box, tall = (
        Object("box", "r2c1", kind="box", size=(0.031, 0.085, 0.039)),
        Object("tall", "r1c1", kind="cylinder", size=(0.054, 0.086)),
    )
    low = Object("low", "r0c1", kind="cylinder", size=(0.046, 0.06))
    answer = Feasibility(build_scene(ManipulationModel("r0c0", COSTS, places, (box, tall, low)))).check("box", "top")
    assert answer.reason is None


def test_what_would_not_rest_on_its_supports_is_not_put_there_while_these_are_there() -> None:
    places = Location("a", at=(0.45, 0.2)), Location("b", at=(0.4, -0.12)), Location("c", at=(0.5, -0.12))
    bar, low = Object("bar", "a", kind="box", size=(0.12, 0.04, 0.03)), Object("low", "c", size=(0.03,), fixed=True)
    model = ManipulationModel(
        "home", COSTS, (*places, Location("top", on=("b", "c"))), (bar, Object("cube", "b", fixed=True), low)
    )
    found = Feasibility(build_scene(model)).check("bar", "top")
    assert found.put_unless == (("cube", "b"), ("low", "c"))
    assert str(found.reason).endswith("bar would not rest on low while cube is at b")


def test_nothing_is_piled_up_through_a_board() -> None:
    """The board would be in the middle of the upper can."""
    shelf = Fixture("shelf", "shelf", at=(0.62, 0.3, 0.0), size=(0.24, 0.5, 0.336), yaw=180, boards=(0.0, 0.136))
    cans = (
        Object("wide", "low", kind="cylinder", size=(0.05, 0.087)),
        Object("slim", "table", kind="cylinder", size=(0.032, 0.085)),
    )
    places = Location("low", at=(0.55, 0.39)), Location("top", on=("low",)), Location("table", at=(0.358, -0.497))
    answer = Feasibility(build_scene(ManipulationModel("home", COSTS, places, cans, fixtures=(shelf,)))).check(
        "slim", "top"
    )
    assert answer.reason == "to put it there: the way is blocked by fixture shelf" and not answer.put


def test_another_grasp_is_tried_where_an_object_cannot_be_raised_in_the_first_one() -> None:
    shelf = Fixture("shelf", "shelf", at=(0.62, 0.3, 0.0), size=(0.24, 0.5, 0.359), yaw=180, boards=(0.0, 0.159))
    box = Object("box", "low", kind="box", size=(0.043, 0.068, 0.071))
    model = ManipulationModel("home", COSTS, (Location("low", at=(0.55, 0.39)),), (box,), fixtures=(shelf,))
    assert Feasibility(build_scene(model)).check("box", "low").take


def test_a_pile_over_which_the_hand_does_not_come_excludes_a_grasp_while_it_is_there() -> None:
    """The arm only just reaches the box, and not from as high as the hand has to pass above the pile."""
    below, far = Location("below", at=(0.398, 0.475)), Location("far", at=(0.569, 0.585))
    places = below, far, Location("pile", on=("below",)), Location("here", at=(0.4, -0.3))
    box = Object("box", "far", kind="box", size=(0.031, 0.085, 0.091))
    pile = Object("cube", "below", size=(0.043,)), Object("post", "pile", kind="box", size=(0.037, 0.053, 0.079))
    model = ManipulationModel("home", COSTS, places, (box, *pile, Object("cup", "here")))
    answer = Feasibility(build_scene(model)).check("box", "far")
    assert answer.barred == [({"box_far", "post_pile"}, "grasp box")]
    assert answer.reason is not None and answer.reason.endswith(" while post is at pile")


@dataclass(frozen=True)
class Fails(Rehearsal):
    """A rehearsal that fails while certain objects are there together."""

    together: tuple[frozenset[str], ...] = ()

    def run(self, *given: object) -> tuple[int, SimulationError | None]:
        """See `Rehearsal.run`."""
        failing = any(each <= self.places.keys() for each in self.together)
        return 0, SimulationError("in the way") if failing else None


@pytest.mark.parametrize(
    ("together", "found"),
    [("ab", {"ab"}), ("ab bc", {"bc", "ab"}), ("a b", {"b", "a"}), ("", {""}), ("o", {""}), ("oc", {"c"})],
)
def test_culprits_are_objects_that_make_a_rehearsal_fail_only_together(together: str, found: set[str]) -> None:
    places = {name: name.upper() for name in "oabc"}
    locations = tuple(Location(name, at=(0.4, 0.1 * k)) for k, name in enumerate(places.values()))
    model = ManipulationModel("home", COSTS, locations, tuple(Object(*each) for each in places.items()))
    sets = tuple(map(frozenset, together.split()))
    failing = Fails(("grasp o",), places, "o", "O", together=sets)
    scene = SimpleNamespace(model=model)
    among = culprits(failing, None, scene, {})  # type: ignore[arg-type]
    assert (among is None) == (not sets) and "".join(among or ()) in found


def test_an_object_is_set_down_below_a_board_with_the_elbow_far_to_one_side() -> None:
    shelf = Fixture("shelf", "shelf", at=(0.62, -0.3, 0.0), size=(0.24, 0.5, 0.378), yaw=180, boards=(0.0, 0.178))
    wall = Fixture("wall", "box", at=(0.418, 0.245, 0.175), size=(0.06, 0.13, 0.35), yaw=104)
    places = Location("low", at=(0.55, -0.21)), Location("out", at=(0.607, 0.177))
    model = ManipulationModel("home", COSTS, places, (Object("cube", "out", size=(0.055,)),), fixtures=(shelf, wall))
    assert Feasibility(build_scene(model)).check("cube", "low").reason is None


def asked(scene: Scene, tried: Callable[[Rehearsal], tuple[int, SimulationError | None]]) -> Feasibility:
    """Return what asks a function in place of rehearsals."""
    found = Feasibility(scene)
    found._attempts.run = tried  # type: ignore[method-assign]
    found._diagnosis = SimpleNamespace(reason=lambda refused, error: str(error))  # type: ignore[assignment]
    return found


def test_what_is_brought_without_the_others_and_grasped_again_can_be_grasped_there() -> None:
    wall = BlockedError.on_the_way({"fixture wall"})

    def tried(rehearsal: Rehearsal) -> tuple[int, SimulationError | None]:
        if len(rehearsal.actions) < BROUGHT:
            return 0, wall
        return (2, NoSpaceError("no room", ["jar"], at_goal=True)) if "jar" in rehearsal.places else (5, None)

    places = (Location(name, at=(0.5, 0.2 * k)) for k, name in enumerate(("here", "there", "by")))
    model = ManipulationModel("home", COSTS, tuple(places), (Object("cup", "here"), Object("jar", "by")))
    answer = asked(build_scene(model), tried).check("cup", "there")
    assert answer.take and answer.put and answer.reason == str(wall)


def test_what_is_put_down_only_as_it_is_grasped_there_is_not_said_to_be_brought(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Feasibility, "_is_placeable", lambda *_: False)
    rack = BlockedError.beside_fingers([{"fixture rack"}])

    def tried(rehearsal: Rehearsal) -> tuple[int, SimulationError | None]:
        return (2, rack) if len(rehearsal.actions) > BROUGHT else (3, None)

    places = (Location(name, at=(0.5, 0.2 * k)) for k, name in enumerate(("here", "there")))
    model = ManipulationModel("home", COSTS, tuple(places), (Object("cup", "here"),))
    answer = asked(build_scene(model), tried).check("cup", "there")
    assert (answer.take, answer.put, answer.reason) == (True, False, f"from here: {rack}")


def low_pantry() -> Scene:
    """Return a jar and a cup under a board, one of them at its edge, so low that the hand does not fit below it."""
    shelf = Fixture("pantry", "shelf", at=(0.62, 0.28, 0.0), size=(0.24, 0.5, 0.3), yaw=180, boards=(0.0, 0.1))
    places = Location("edge", at=(0.53, 0.36)), Location("deep", at=(0.60, 0.2))
    objects = Object("jar", "deep", kind="cylinder", size=(0.045, 0.06)), Object("cup", "edge")
    return build_scene(ManipulationModel("home", COSTS, places, objects, fixtures=(shelf,)))


def test_that_a_board_is_too_low_for_the_hand_is_found_without_the_arm(monkeypatch: pytest.MonkeyPatch) -> None:
    searches: list[np.ndarray] = []
    search = Arm._search

    def counted(arm: Arm, goal: ToolPose, seed: np.ndarray) -> tuple[np.ndarray, float] | None:
        searches.append(seed)
        return search(arm, goal, seed)

    monkeypatch.setattr(Arm, "_search", counted)
    missing(Feasibility(low_pantry()).check("jar", "deep"), r"(?:out of reach below pantry|.* too low .*) by (\d+) cm")
    assert len(searches) < 400


def test_no_grasp_is_free_in_which_the_hand_alone_is_inside_something() -> None:
    scene = low_pantry()
    cell = KinematicCell(scene, initial_state(scene))
    inside = 0
    for obj in scene.shapes:
        pose = cell.observe(obj)
        for grasp in list(ranked(pose.shape, scene.robot.gripper, pose.rotation))[::5]:
            goals = grasp.at(pose.position, pose.rotation).symmetric_poses()
            if all(cell.hand_is_inside(goal, touching=obj, width=grasp.opening) for goal in goals):
                inside += 1
                with pytest.raises(SimulationError):
                    free_pose(cell, goals, grasp, obj)
    assert inside > 50


def test_a_hand_that_cannot_be_where_it_starts_is_told_as_in_a_run() -> None:
    shelf = Fixture("low", "shelf", at=(0.55, 0.25, 0.0), size=(0.25, 0.3, 0.5), yaw=180, boards=(0.0, 0.16))
    places = Location("under", at=(0.55, 0.25)), Location("here", at=(0.45, -0.2))
    model = ManipulationModel("under", COSTS, places, (Object("cup", "here"),), fixtures=(shelf,))
    scene = build_scene(model)
    words = "model.start: the hand cannot begin over 'under': the way is blocked by fixture low"
    assert Feasibility(scene).check_start() == words
    with pytest.raises(SimulationError, match=re.escape(words)):
        Execution(scene, initial_state(scene))
    elsewhere = build_scene(replace(model, start="here"))
    assert Feasibility(elsewhere).check_start() is None


def test_an_object_in_a_corner_is_drawn_free_as_in_a_run() -> None:
    model = loads(CORNER).model
    assert isinstance(model, ManipulationModel)
    found = Feasibility(build_scene(model))
    assert found.check("cup", "tray") == PlaceCheck("cup", "tray")


def test_what_walls_alone_keep_from_the_hand_is_refused_though_an_object_is_in_the_way_too() -> None:
    places = Location("here", at=(0.5, 0.0)), Location("front", at=(0.434, 0.0))
    objects = Object("cup", "here"), Object("jar", "front")
    walls = [
        Fixture(name, "box", at=(0.5, y, 0.06), size=(0.2, 0.02, 0.12)) for name, y in (("a", 0.034), ("b", -0.034))
    ]
    model = ManipulationModel("home", COSTS, places, objects, fixtures=tuple(walls), robot="panda_suction")
    found = Feasibility(build_scene(model)).check("cup", "here")
    assert not found.take and not found.put
    assert found.reason == "no room for the fingers: they would touch fixture a and fixture b"


def test_the_joints_that_would_have_to_turn_farther_are_named() -> None:
    arm = Arm(replace(PANDA))  # its model is changed
    goal = arm.tool(PANDA.home)
    assert arm.missing_turns(goal) == {}
    arm.model.jnt_range[-1, 1] = PANDA.home[-1] - np.radians(20)
    (name, turn), *others = arm.missing_turns(goal).items()
    assert (name, others) == ("joint7", []) and np.degrees(turn) == pytest.approx(20, abs=1)
    assert arm.missing_turns(goal.shifted([2.0, 0.0, 0.0])) == {}


@pytest.mark.parametrize("name", ["case_study_3", "clutter", "shelf"])
def test_the_pairs_are_those_of_which_a_state_of_the_model_tells(name: str) -> None:
    model = shipped(name).model
    assert isinstance(model, ManipulationModel)
    found = {place for label in model.transition_system().listed.label_sets for place in label}
    pairs = {(obj.name, place.name) for obj in model.objects for place in model.locations if not obj.fixed}
    assert set(allowed_places(model)) == {(obj, place) for obj, place in pairs if f"{obj}_{place}" in found}


def test_others_are_left_where_they_start_unless_they_are_in_the_way() -> None:
    model = shipped("kitchen").model
    assert isinstance(model, ManipulationModel)
    start = {obj.name: obj.start for obj in model.objects}
    assert arranged(model, "pie", "pile") == start
    assert arranged(model, "soup", "board") == {"soup": "board", "fish": "counter", "mug": "plate2"}
    assert arranged(model, "fish", "plate2") == {"soup": "board", "pie": "pile", "fish": "plate2"}
    assert arranged(model, "mug", "counter") == start | {"mug": "counter"}
    assert arranged(model, "soup", "pile") == {"soup": "pile", "pie": "board", "fish": "counter", "mug": "plate2"}


def test_what_the_arm_cannot_do_is_left_out_of_the_model() -> None:
    places = (Location("here", at=(0.5, 0.0)), Location("far", at=(0.83, 0.0)))
    model = ManipulationModel("home", COSTS, places, (CUP,), fixtures=(POST,), robot="panda_suction")
    feasibility = Feasibility(build_scene(model))
    here, far = feasibility.check("cup", "here"), feasibility.check("cup", "far")
    assert here == PlaceCheck("cup", "here") and re.fullmatch(r"out of reach by \d cm", far.reason or "")
    barred = [*here.barred, *far.barred]
    assert set(barred) == {(frozenset({"cup_far"}), "grasp cup"), (frozenset(), "release cup far")}
    system = model.transition_system().without(barred)
    state = system.start
    for action in ("transit here", "grasp cup", "transport cup far"):
        state, _ = system.step(state, action)
    with pytest.raises(ModelError, match="release cup far"):
        system.step(state, "release cup far")


def test_what_can_be_put_back_where_it_is_grasped_is_brought_from_wherever_that_can_be_done() -> None:
    """Only the grasps that are possible at `far` fit at the goal, too."""
    tried = list[str]()

    def only_from_far(rehearsal: Rehearsal) -> tuple[int, SimulationError | None]:
        if len(rehearsal.actions) < BROUGHT:
            return len(rehearsal.actions), None
        tried.append(rehearsal.actions[0].removeprefix("transit "))
        return (5, None) if tried[-1] == "far" else (2, BlockedError.beside_fingers([{"fixture wall"}]))

    names = "goal", "start", "beside", "near", "next", "far", "farther"
    places = (Location(name, at=(0.5, 0.1 * k - 0.3)) for k, name in enumerate(names))
    model = ManipulationModel("home", COSTS, tuple(places), (Object("cup", "start"),))
    answer = asked(build_scene(model), only_from_far).check("cup", "goal")
    assert answer.put and answer.take and answer.reason is not None
    assert list(dict.fromkeys(tried)) == ["start", "beside", "near", "next", "far"]


def test_what_no_grasp_brings_directly_between_walls_goes_by_way_of_another_location(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    walls = (
        Fixture("left", "box", at=(0.279, -0.328, 0.185), size=(0.09, 0.17, 0.37), yaw=114),
        Fixture("right", "box", at=(0.339, -0.538, 0.195), size=(0.06, 0.09, 0.39), yaw=40),
    )
    places = (
        Location("here", at=(0.594, 0.096)),
        Location("far", at=(0.804, 0.11)),
        Location("deep", at=(0.436, -0.357)),
    )
    bar = Object("bar", "here", kind="box", size=(0.045, 0.065, 0.033), mass=0.05)
    model = ManipulationModel("home", COSTS, places, (bar,), fixtures=walls)
    scene = build_scene(model)
    arm = Capability(model, scene=scene)
    refused = arm.rehearse(Transfer("bar", "here", "deep", ()))
    assert refused and refused.barred == [({"bar from here"}, "release bar deep")]
    assert not arm.rehearse(Transfer("bar", "far", "deep", ()))
    plan = Planner(Problem(model, {"t": "F bar_deep"}, Order(), feasible=arm)).cheapest()
    assert plan.actions[2] == "transport bar far" and len(plan.actions) == 7
    run = Execution(scene, initial_state(scene))
    assert all(run.step(action, ahead=plan.actions[k + 1 :]) for k, action in enumerate(plan.actions)), run.reason
