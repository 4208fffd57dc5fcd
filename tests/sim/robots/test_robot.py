from __future__ import annotations

from dataclasses import replace

import mujoco
import pytest

from sim.errors import RobotError
from sim.robots.arms.panda import PANDA
from sim.robots.robot import Robot


@pytest.mark.parametrize(
    ("robot", "lacking"),
    [
        (replace(PANDA, base="foot"), "body 'foot'"),
        (replace(PANDA, joints=(*PANDA.joints[:6], "wrist")), "joint 'wrist'"),
        (replace(PANDA, tool="tip"), "site 'tip'"),
        (replace(PANDA, gripper=replace(PANDA.gripper, actuator="jaw")), "actuator 'jaw'"),
        (replace(PANDA, gripper=replace(PANDA.gripper, pads=("left_pad", "pad"))), "geom 'pad'"),
    ],
)
def test_what_the_mjcf_lacks_is_named(robot: Robot, lacking: str) -> None:
    with pytest.raises(RobotError, match=f"the robot `panda` has no {lacking} in its MJCF"):
        robot.spec()


def test_parts_without_a_name_are_not_listed() -> None:
    robot = replace(PANDA, gripper=replace(PANDA.gripper, pads=("left_pad", "zzz")))
    with pytest.raises(RobotError, match=r"no geom 'zzz' in its MJCF \(valid: link0_shell, link0_trim, link1_shell"):
        robot.spec()


def test_a_robot_whose_files_are_missing_is_named() -> None:
    def missing() -> mujoco.MjSpec:
        raise RobotError("it needs the package x")

    with pytest.raises(RobotError, match="^the robot `panda` is not available here: it needs the package x$"):
        replace(PANDA, mjcf=missing).spec()
