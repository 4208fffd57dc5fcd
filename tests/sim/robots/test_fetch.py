"""Fetch's arm and gripper, as gymnasium-robotics describes them."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sim.errors import RobotError
from sim.robots.arms.fetch import TABLE_HEIGHT_M, unavailable_because
from sim.robots.catalogue import robot_named
from sim.robots.import_mjcf import PREFIX, _imported
from sim.robots.robot import Robot

pytestmark = pytest.mark.skipif(unavailable_because() is not None, reason="its meshes are not installed")


@pytest.fixture(scope="module")
def robot() -> Robot:
    return robot_named("fetch")


@pytest.fixture(scope="module")
def fetch(robot: Robot) -> mujoco.MjModel:
    return robot.spec().compile()


def test_only_the_arm_and_the_fingers_move_and_all_joints_have_ends(robot: Robot, fetch: mujoco.MjModel) -> None:
    moving = {fetch.joint(i).name for i in range(fetch.njnt)}
    assert moving == {*robot.joints, *robot.gripper.joints}
    assert np.all(np.ptp(robot.ranges(fetch), axis=1) > 1)


def test_stretched_out_it_reaches_as_far_as_its_links_are_long(robot: Robot, fetch: mujoco.MjModel) -> None:
    """Fetch Robotics' URDF: origins of the joints, from the shoulder's axis to the gripper."""
    along = 0.117 + 0.219 + 0.133 + 0.197 + 0.1245 + 0.1385 + 0.16645
    data = mujoco.MjData(fetch)
    robot.put(data, np.zeros(7), width=0.0)
    mujoco.mj_kinematics(fetch, data)
    wrist = data.body(PREFIX + "robot0:gripper_link").xpos - robot.position
    assert wrist[:2] == pytest.approx([along, 0], abs=1e-3)
    assert wrist[2] == pytest.approx(0.377425 + 0.3861 + 0.34858 + 0.06 - TABLE_HEIGHT_M, abs=1e-3)


def test_without_its_meshes_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    _imported.cache_clear()
    with pytest.raises(RobotError, match="pip install gymnasium-robotics; the robot `panda` needs"):
        robot_named("fetch")
