"""The choice of a grasp beside walls, compared with one that tries every grasp, first where the object is."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from prefplan.models.manipulation.surroundings import Fixture
from sim.capability.rehearsal import Rehearsal
from sim.errors import BlockedError, SimulationError
from sim.motion.trajectory import ToolPose
from sim.simulation.kinematic_cell import KinematicCell
from sim.skills.catalogue import SKILLS
from sim.skills.grasp_choice import ChosenGrasp, _can_place, _next_slot, find_grasp, freely
from sim.skills.hand import frame_of, free_pose
from sim.world.grasps import GraspPose, ranked
from sim.world.scene import build_scene, initial_state

COSTS = {"transit": 1, "grasp": 1, "transport": 1, "release": 1}

WALLS = (
    Fixture("left", "box", at=(0.436, -0.195, 0.185), size=(0.09, 0.17, 0.37), yaw=114),
    Fixture("right", "box", at=(0.53, -0.44, 0.195), size=(0.06, 0.09, 0.39), yaw=40),
)
"""Walls higher than the hand, between which there is hardly any space for it."""


def cell_of(obj: Object, *fixtures: Fixture) -> KinematicCell:
    places = Location("here", at=(0.5, 0.2)), Location("between", at=(0.53, -0.26))
    scene = build_scene(ManipulationModel("home", COSTS, places, (obj,), fixtures=fixtures))
    return KinematicCell(scene, initial_state(scene))


def test_where_a_body_is_at_the_hand_in_one_pose_another_is_taken() -> None:
    cell = cell_of(Object("cup", "between"), WALLS[0])
    pose = cell.observe("cup")
    free, blocked = list[tuple[GraspPose, ToolPose]](), list[tuple[GraspPose, ToolPose]]()
    for grasp in ranked(pose.shape, cell.scene.robot.gripper, pose.rotation):
        goal = grasp.at(pose.position, pose.rotation)
        try:
            free_pose(cell, [goal], grasp, "cup")
            free.append((grasp, goal))
        except BlockedError as error:
            if error.by == ("fixture left",):
                blocked.append((grasp, goal))
        except SimulationError:
            continue
    pairs = [
        (grasp, [other, goal])
        for (grasp, goal), (alike, other) in itertools.product(free[:5], blocked[:20])
        if grasp.opening == alike.opening and goal.points_down == other.points_down
    ]
    assert len(pairs) > 20
    for grasp, goals in pairs:
        for options in (goals, goals[::-1]):
            assert free_pose(cell, options, grasp, "cup")[1] is goals[1]


def naive(cell: KinematicCell, obj: str, destination: str) -> ChosenGrasp | None:
    """Return the first grasp that is free where an object stands and at the destination, or barely so, or else here."""
    pose, slot = cell.observe(obj), _next_slot(cell, obj, destination)
    frame, choices = frame_of(pose, pose.yaw), list[ChosenGrasp]()
    for grasp in ranked(pose.shape, cell.scene.robot.gripper, frame):
        try:
            choices.append(freely(cell, obj, pose, frame, grasp))
        except SimulationError:
            continue
    assert slot is not None
    for barely in (False, True):
        for choice in choices:
            if _can_place(cell, obj, slot, choice.grasp, barely=barely):
                return choice
    return next(iter(choices), None)


@pytest.mark.parametrize(
    "obj",
    [
        Object("cup", "here"),
        Object("can", "here", kind="cylinder", size=(0.04, 0.06)),
        Object("bar", "here", kind="box", size=(0.03, 0.07, 0.05)),
    ],
    ids=lambda obj: obj.name,
)
@pytest.mark.parametrize("walls", [(), WALLS[:1], WALLS], ids=len)
def test_the_grasp_chosen_is_the_first_that_every_test_allows(obj: Object, walls: tuple[Fixture, ...]) -> None:
    cell = cell_of(obj, *walls)
    pose = cell.observe(obj.name)
    found, right = (
        find_grasp(cell, obj.name, pose, pose.yaw, destination="between"),
        naive(cell_of(obj, *walls), obj.name, "between"),
    )
    assert (found is None) == (right is None)
    if found and right:
        assert np.array_equal(found.tool.rotation, right.tool.rotation)
        assert np.array_equal(found.tool.position, right.tool.position) and found.grasp.opening == right.grasp.opening


def test_a_hand_that_is_tilted_after_a_release_takes_another_grasp_where_only_that_suits_the_next_location() -> None:
    wall = Fixture("wall", "box", at=(0.414, -0.114, 0.165), size=(0.04, 0.15, 0.33), yaw=27)
    spots = {"far": (0.526, 0.627), "on_the_way": (0.67, 0.39), "beside": (0.27, -0.024)}
    box = Object("box", "far", kind="box", size=(0.038, 0.081, 0.074))
    places = tuple(Location(name, at=at) for name, at in spots.items())
    scene = build_scene(ManipulationModel("home", COSTS, places, (box,), fixtures=(wall,)))
    there = "transit far", "grasp box", "transport box on_the_way", "release box on_the_way"
    actions = (*there, "grasp box", "transport box beside", "release box beside")
    rehearsal = Rehearsal(actions, {"box": "far"}, "box", "beside")
    assert rehearsal.run(KinematicCell(scene, initial_state(scene)), scene, SKILLS) == (len(actions), None)
