"""A robot with another base pose: the same scene moved and turned, and a run in it."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest
from scenario_texts import cup_scenario
from skill_runs import assert_clean, assert_placed, perform_all

from prefplan.errors import PrefplanError
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.manipulation.surroundings import RobotSetup
from prefplan.scenario.decode import from_dict, loads
from sim.motion.kinematics import Arm
from sim.motion.trajectory import ToolPose
from sim.robots.arms.panda import PANDA
from sim.robots.catalogue import robot_for
from sim.world.scene import Scene, build_scene

BASE, YAW = np.array([0.2, -0.4, 0.1]), 70.0


def moved(x: float, y: float) -> list[float]:
    c, s = np.cos(np.radians(YAW)), np.sin(np.radians(YAW))
    return [float(BASE[0] + c * x - s * y), float(BASE[1] + s * x + c * y)]


@pytest.fixture(scope="module")
def scene() -> Scene:
    places = {name: f"{{ at = {moved(*at)} }}" for name, at in {"desk": (0.5, 0.1), "tray": (0.45, -0.2)}.items()}
    table = f"[model.robot]\nat = {BASE.tolist()}\nyaw = {YAW}\n[model.locations]"
    model = loads(cup_scenario(places=places).replace("[model.locations]", table)).model
    assert isinstance(model, ManipulationModel)
    return build_scene(model)


def test_the_arm_reaches_what_moved_with_its_base_as_before() -> None:
    elsewhere = robot_for(RobotSetup(at=tuple(BASE), yaw=YAW))
    for x, y in ((0.5, 0.1), (0.4, -0.3)):
        q, _ = Arm(PANDA).reach([ToolPose.down(np.array([x, y, 0.2]), 0.3)])
        goal = ToolPose.down(np.array([*moved(x, y), 0.2 + BASE[2]]), 0.3 + np.radians(YAW))
        p, _ = Arm(elsewhere).reach([goal])
        assert p == pytest.approx(q, abs=1e-4)


def test_the_table_and_a_pedestal_carry_the_base(scene: Scene) -> None:
    assert (abs(scene.table.centre - BASE[:2]) < scene.table.half).all()
    pedestal = scene.mujoco.geom("robot pedestal")
    assert pedestal.pos[2] + scene.mujoco.body("robot pedestal").pos[2] + pedestal.size[2] == pytest.approx(BASE[2])


def test_the_arm_works_from_there(scene: Scene) -> None:
    cell = perform_all(scene, "transit desk", "grasp cup", "transport cup tray", "release cup tray")
    assert_clean(cell)
    assert_placed(cell, "cup", "tray")


@pytest.mark.parametrize(
    ("robot", "message"),
    [
        ({"at": [1e9, 0]}, "robot.at: must be metres, at most 1000, not [1000000000.0, 0.0]"),
        ({"at": [0, 0, 0, 1]}, "robot.at: must be [x, y] or [x, y, height] in metres, not [0.0, 0.0, 0.0, 1.0]"),
        ({"at": [0, 0, -0.2]}, "robot.at: the base is 0.2 m below the table top; at least 0"),
        ({"yaw": "left"}, "robot.yaw: must be a number, not 'left'"),
        ({"yaw": 10, "add": 1}, "robot.add: unknown key"),
    ],
)
def test_a_base_that_cannot_stand_is_refused(robot: dict[str, object], message: str) -> None:
    data = tomllib.loads(cup_scenario())
    data["model"]["robot"] = robot
    with pytest.raises(PrefplanError) as caught:
        build_scene(from_dict(data).model)  # type: ignore[arg-type]
    assert str(caught.value).rpartition("model.")[2].startswith(message)
