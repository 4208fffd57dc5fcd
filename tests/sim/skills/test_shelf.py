from typing import Any

import mujoco
import numpy as np
import pytest
from scenario_texts import shipped
from scipy.spatial.transform import Rotation
from skill_runs import assert_clean, assert_good, assert_placed, perform_all

from prefplan import ManipulationModel
from prefplan.models.manipulation.model import Fixture, Location, Object
from prefplan.scenario.decode import loads
from sim.errors import BlockedError
from sim.execution.executor import execute
from sim.geometry.rectangle import Rectangle, contains
from sim.motion.trajectory import ToolPose
from sim.simulation.workcell import Workcell
from sim.skills import grasp
from sim.skills.catalogue import perform
from sim.skills.hand import pregrasps
from sim.skills.regrasp import find_regrasp
from sim.world.scene import build_scene, initial_state


def test_the_hand_takes_what_stands_under_a_board_from_the_front_and_puts_it_down_there() -> None:
    scene = build_scene(shipped("shelf").model)
    cell = perform_all(scene, "transit pile", seed=None)
    tool, board = cell.arm.tool(cell.angles), scene.slots["high"][0].position[2]
    assert tool.position[2] < board and tool.rotation[0, 2] > 0.2  # tilted towards the shelf, and below the board
    for action in ("grasp jam", "transport jam aside", "release jam aside"):
        perform(cell, action)
    assert_clean(cell)
    assert_placed(cell, "jam", "aside")


def test_a_tilted_hand_that_cannot_come_from_above_comes_along_its_axis_and_a_level_one_from_a_little_above() -> None:
    for tilt in np.radians([30, 60, 90]):
        pose = ToolPose(np.zeros(3), Rotation.from_euler("y", np.pi - tilt).as_matrix())
        back, axis = pregrasps(pose)[1].position, pose.rotation[:, 2]
        assert back[2] >= 0.02 and np.allclose(back[:2], -0.08 * axis[:2])
        assert np.allclose(np.cross(back, axis), 0) or np.isclose(tilt, np.pi / 2)


COSTS = {"transit": 1, "grasp": 1, "transport": 1, "release": 1}

SHELF = Fixture("shelf", "shelf", at=(0.62, -0.3, 0.0), size=(0.24, 0.5, 0.386), yaw=180, boards=(0.0, 0.186))
LOW, HIGH = Location("low", at=(0.55, -0.21)), Location("high", at=(0.55, -0.3, 0.186))


@pytest.mark.parametrize("empty", [False, True])
def test_a_hand_above_a_board_does_not_hide_it(empty: bool) -> None:
    places = LOW, HIGH, Location("top", on=("low",)), Location("a", at=(0.45, 0.2)), Location("b", at=(0.45, 0.4))
    block, can = Object("block", "b" if empty else "low"), Object("can", "a", kind="cylinder", size=(0.04, 0.098))
    scene = build_scene(ManipulationModel("home", COSTS, places, (block, can), fixtures=(SHELF,)))
    cell = perform_all(scene, "transit high")
    if empty:
        with pytest.raises(BlockedError, match="shelf"):
            perform(cell, "transit top")
    else:
        perform(cell, "transit top")
        assert cell.arm.tool(cell.angles).position[2] < scene.slots["high"][0].position[2]


def test_what_lies_on_a_low_object_below_a_board_is_taken_though_a_tall_one_could_be_there() -> None:
    places = (
        LOW,
        HIGH,
        Location("top", on=("low",)),
        Location("table", at=(0.45, 0.2)),
        Location("free", at=(0.45, 0.4)),
    )
    low, tall = Object("block", "low", size=(0.034,)), Object("can", "table", kind="cylinder", size=(0.04, 0.098))
    lid = Object("lid", "top", kind="cylinder", size=(0.044, 0.033))
    scene = build_scene(ManipulationModel("home", COSTS, places, (low, tall, lid), fixtures=(SHELF,)))
    cell = perform_all(scene, "transit top", "grasp lid", "transport lid free", "release lid free")
    assert_clean(cell)
    assert_placed(cell, "lid", "free")


def test_a_load_that_cannot_be_drawn_out_all_the_way_is_drawn_out_half_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = build_scene(shipped("shelf").model)
    cell = perform_all(scene, "transit pile", seed=None)
    move_tool, longest = grasp.move_tool, 0.05

    def blocked_far_out(cell: Workcell, goal: ToolPose, **options: Any) -> None:
        if cell.held() and np.linalg.norm(goal.position - cell.arm.tool(cell.angles).position) > longest:
            raise BlockedError.on_the_way({"fixture shelf"})
        move_tool(cell, goal, **options)

    monkeypatch.setattr(grasp, "move_tool", blocked_far_out)
    perform(cell, "grasp jam")
    assert cell.held() == "jam" and cell.observe("jam").underside[2] > scene.slots["pile"][0].position[2] + 0.005
    assert_clean(cell)


BESIDE = """
[model]
kind = "manipulation"
start = "board"
costs = { transit = 1, grasp = 1, transport = 1, release = 1 }

[model.fixtures]
shelf = { kind = "shelf", at = [0.62, 0.28, 0], size = [0.24, 0.50, 0.45], yaw = 180, boards = [0.0, 0.25] }

[model.locations]
board = { at = [0.55, 0.28, 0.25] }
table = { at = [0.45, -0.20] }

[model.objects]
can = { start = "board", kind = "cylinder", size = [0.045, 0.08] }
box = { start = "table" }

[[tasks]]
name = "fetch"
formula = "F can_table"

[preference]
kind = "order"
"""


def test_nothing_is_set_aside_in_front_of_a_board() -> None:
    model = loads(BESIDE).model
    assert isinstance(model, ManipulationModel)
    scene = build_scene(model)
    data = initial_state(scene)
    lying = Rotation.from_euler("ZY", [90, 90], degrees=True)
    data.joint("can").qpos[:3] = 0.56, 0.28, 0.25 + 0.0225
    data.joint("can").qpos[3:] = lying.as_quat(scalar_first=True)
    # Over one end of the can, so that it cannot be set down where it is.
    data.joint("box").qpos[:3] = 0.56, 0.34, 0.30
    mujoco.mj_forward(scene.mujoco, data)
    cell = Workcell(scene, data)
    cell.touch("can")
    turn = find_regrasp(cell, "can", cell.measure("can"), None)
    assert turn is not None
    place = turn.pose.footprint
    assert contains(Rectangle(np.array([0.62, 0.28]), np.array([0.12, 0.25]), 0.0), place)


def test_under_a_low_board_the_hand_comes_to_rest_before_the_object_in_it_is_measured() -> None:
    shelf = Fixture("rack", kind="shelf", at=(0.55, 0.4, 0.0), size=(0.238, 0.364, 0.45), yaw=180, boards=(0.0, 0.205))
    places = Location("l0", at=(0.432, -0.026)), Location("l1", at=(0.464, 0.077)), Location("g", at=(0.55, 0.4, 0.0))
    can = Object("can", "l1", kind="cylinder", size=(0.058, 0.067))
    scene = build_scene(
        ManipulationModel("home", COSTS, (*places, Location("l2", at=(0.342, 0.034))), (can,), fixtures=(shelf,))
    )
    run = execute(scene, ["transit l1", "grasp can", "transport can g", "release can g"])
    assert_good(run)


def test_a_tilted_hand_takes_an_object_as_it_is_tilted(monkeypatch: pytest.MonkeyPatch) -> None:
    def chosen(*_: Any, **__: Any) -> None:
        raise AssertionError("a grasp from another side was looked for")

    scene = build_scene(shipped("shelf").model)
    cell = perform_all(scene, "transit pile", seed=None)
    monkeypatch.setattr(grasp, "choose_grasp", chosen)
    before = cell.arm.tool(cell.reference).rotation[:, 2]
    perform(cell, "grasp jam", ahead=("transport jam aside", "release jam aside"))
    assert before @ cell.arm.tool(cell.reference).rotation[:, 2] > np.cos(np.radians(15))
