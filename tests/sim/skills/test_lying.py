"""Lying objects are grasped with a tilted hand and set upright where they are put down."""

from __future__ import annotations

from contextlib import nullcontext
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from skill_runs import assert_placed, contacts

from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from prefplan.models.manipulation.surroundings import Fixture
from sim.errors import BlockedError
from sim.execution.faults.fault import Injection
from sim.execution.faults.miss import Miss
from sim.motion.trajectory import ToolPose
from sim.perception.sensors import object_pose
from sim.simulation.workcell import Workcell
from sim.skills import grasp, hand, regrasp
from sim.skills.catalogue import SKILLS, perform
from sim.skills.skill import SkillError
from sim.world.scene import build_scene, initial_state

COSTS = {"transit": 1, "grasp": 1, "transport": 1, "release": 1}
LOCATIONS = Location("near", at=(0.45, -0.2)), Location("dish", at=(0.5, 0.2), kind="plate")


def lying(kind: str, size: tuple[float, ...], heading: float) -> Workcell:
    """Return a running simulation in which x lies at `near` with a heading, rad, to be put onto the dish."""
    model = ManipulationModel("home", COSTS, LOCATIONS, (Object("x", "near", kind=kind, size=size),))
    scene = build_scene(model)
    data = initial_state(scene)
    rotation = Rotation.from_euler("ZY", [heading, np.pi / 2])
    data.joint("x").qpos[2] = scene.shapes["x"].depth(rotation.as_matrix())
    data.joint("x").qpos[3:] = rotation.as_quat(scalar_first=True)
    mujoco.mj_forward(scene.mujoco, data)
    assert not object_pose(scene, data, "x").is_upright
    return Workcell(scene, data)


@pytest.mark.parametrize(
    ("kind", "size", "heading"),
    [
        ("cylinder", (0.03, 0.06), 0.5),
        ("cylinder", (0.03, 0.06), 2.6),
        ("cylinder", (0.06, 0.03), 1.0),
        ("box", (0.04, 0.05, 0.03), 2.0),
        # Its only level closing direction would be vertical in the end: it is set down on a third face first.
        ("box", (0.07, 0.04, 0.055), 0.5),
        # The palm would touch an end of these, or the hand the table, were they taken in their middle.
        ("box", (0.05, 0.04, 0.09), 2.0),
        ("cylinder", (0.055, 0.10), 0.5),
    ],
)
def test_what_lies_is_taken_and_set_upright(kind: str, size: tuple[float, ...], heading: float) -> None:
    cell = lying(kind, size, heading)
    for action in ("transit near", "grasp x", "transport x dish", "release x dish"):
        perform(cell, action, ahead=["release x dish"])
    assert object_pose(cell.scene, cell.data, "x").tilt < np.radians(1)
    assert_placed(cell, "x", "dish")
    assert contacts(cell.events) == []


def test_an_object_is_not_set_down_in_a_wall_that_stands_beside_it() -> None:
    """A wall on the table, higher than the object, is where two corners would be 10 cm nearer to the robot."""
    wall = Fixture("wall", "box", at=(0.31, -0.2, 0.1), size=(0.02, 0.2, 0.2))
    objects = (Object("x", "near", kind="box", size=(0.05, 0.04, 0.09)),)
    scene = build_scene(ManipulationModel("home", COSTS, LOCATIONS, objects, fixtures=(wall,)))
    data = initial_state(scene)
    turned = Rotation.from_euler("y", np.pi / 2).as_matrix()
    data.joint("x").qpos[2] = scene.shapes["x"].depth(turned)
    data.joint("x").qpos[3:] = Rotation.from_matrix(turned).as_quat(scalar_first=True)
    mujoco.mj_forward(scene.mujoco, data)
    cell = Workcell(scene, data)
    centres = list(regrasp._centres(cell, "x", cell.observe("x"), turned))
    shifts = np.round([centre[:2] - [0.45, -0.2] for centre in centres], 3)
    assert shifts.tolist() == [[0.0, 0.0], [0.0, 0.1], [0.0, -0.1], [0.1, 0.0]]


def test_a_hand_that_gives_way_gets_no_grip_on_what_lies_and_then_does() -> None:
    cell, skills = lying("box", (0.06, 0.05, 0.03), 0.0), dict(SKILLS)
    perform(cell, "transit near", skills)
    Miss(1, "1").inject(Injection(cell, skills, iter(()), np.random.default_rng(0), 0.0))
    with pytest.raises(SkillError, match="without a firm grip on x"):
        perform(cell, "grasp x", skills)
    perform(cell, "grasp x", skills)
    assert cell.held() == "x" and contacts(cell.events) == []


@pytest.mark.parametrize(
    ("refusals", "held"),
    [(1, "x"), (4, "x"), (99, None)],
    ids=["raised straight up", "taken from elsewhere", "let go"],
)
def test_what_cannot_be_raised_the_way_the_hand_came(
    monkeypatch: pytest.MonkeyPatch, refusals: int, held: str | None
) -> None:
    cell, left = lying("cylinder", (0.06, 0.03), 1.0), [BlockedError("blocked by y", {"y"})] * refusals
    refused: list[ToolPose] = []

    def move_tool(cell: Workcell, goal: ToolPose, **options: Any) -> None:
        if cell.held() and left:
            refused.append(cell.arm.tool(cell.reference))
            raise left.pop()
        hand.move_tool(cell, goal, **options)

    monkeypatch.setattr(grasp, "move_tool", move_tool)
    monkeypatch.setattr(grasp, "find_drag", lambda *_: None)  # nor dragged away from y
    perform(cell, "transit near")
    with nullcontext() if held else pytest.raises(BlockedError):
        perform(cell, "grasp x", ahead=["release x dish"])
    cell.settle()
    assert cell.held() == held and refused
    if held:
        again = cell.arm.tool(cell.reference).rotation[:, 2] @ refused[0].rotation[:, 2] > np.cos(np.radians(14))
        assert again == (refusals == 1) and not left
    assert (cell.observe("x").position[2] > 0.1) == (held is not None)
