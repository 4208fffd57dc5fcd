from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sim.motion.kinematics import Arm
from sim.motion.trajectory import ToolPose
from sim.perception.touch import ContactMonitor
from sim.robots.arms.panda import PANDA
from sim.world.scene import Scene, initial_state


@pytest.fixture(scope="module")
def arm() -> Arm:
    return Arm(PANDA)


def posed(scene: Scene, arm: Arm, position: tuple[float, float, float], *, width: float = 0.07) -> mujoco.MjData:
    """Return the start state with the tool at a position, its fingers pressing along x."""
    data = initial_state(scene)
    q, _ = arm.reach(ToolPose.down(np.array(position), 0.0).symmetric_poses())
    PANDA.put(data, q, width=width)
    data.actuator(PANDA.gripper.actuator).ctrl[0] = 0.0
    mujoco.mj_forward(scene.mujoco, data)
    return data


def test_an_arm_in_the_air_touches_nothing(scene: Scene) -> None:
    assert ContactMonitor(scene).update(initial_state(scene)) == []


def test_a_finger_in_the_table_is_told(scene: Scene, arm: Arm) -> None:
    touches = ContactMonitor(scene).update(posed(scene, arm, (0.45, 0.0, 0.008)))
    assert ("left_finger", "table") in touches and ("right_finger", "table") in touches


def test_fingers_may_touch_only_what_they_handle(scene: Scene, arm: Arm) -> None:
    data = posed(scene, arm, (0.50, 0.0, 0.0675), width=0.044)
    monitor = ContactMonitor(scene)
    assert {other for _, other in monitor.update(data)} == {"pink"}
    monitor.handle("blue")
    assert {other for _, other in monitor.update(data)} == {"pink"}
    monitor.handle("pink")
    assert monitor.update(data) == []
    assert monitor.pad_forces.min() > 0.5 and monitor.pressed == data.time


def test_what_is_aloft_may_touch_nothing_but_the_pads(scene: Scene, arm: Arm) -> None:
    data = posed(scene, arm, (0.50, 0.0, 0.0675), width=0.044)
    data.joint("pink").qpos[2] -= 0.0005
    mujoco.mj_forward(scene.mujoco, data)
    monitor = ContactMonitor(scene)
    monitor.handle("pink", aloft=True)
    assert set(monitor.update(data)) == {("pink", "blue"), ("pink", "green")}
    monitor.handle(None)
    assert not monitor.aloft


def test_the_palm_may_not_touch_what_is_handled(scene: Scene, arm: Arm) -> None:
    monitor = ContactMonitor(scene)
    monitor.handle("pink")
    assert ("hand", "pink") in monitor.update(posed(scene, arm, (0.50, 0.0, 0.048)))
