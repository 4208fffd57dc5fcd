from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sim.motion.dynamics import InverseDynamics
from sim.motion.kinematics import Arm
from sim.motion.trajectory import CONTROL_PERIOD_S, ToolPose
from sim.robots.arms.panda import PANDA

LOAD_KG = 2.5


@pytest.fixture(scope="module")
def loaded() -> mujoco.MjModel:
    """The arm with a body of a few millimetres and `LOAD_KG` at its tool, for MuJoCo's own inverse dynamics."""
    spec = PANDA.spec()
    for name in PANDA.gripper.joints:
        spec.delete(spec.joint(name).parent)
    tool = spec.site(PANDA.tool)
    tool.parent.add_body(
        pos=tool.pos, ipos=[0, 0, 0], mass=LOAD_KG, inertia=[1e-9] * 3, explicitinertial=True, gravcomp=0
    )
    model = spec.compile()
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    return model


@pytest.mark.parametrize("seed", range(3))
def test_torques_are_those_of_mujocos_inverse_dynamics_with_the_load_as_a_body(
    loaded: mujoco.MjModel, seed: int
) -> None:
    rng, data = np.random.default_rng(seed), mujoco.MjData(loaded)
    q, velocity, acceleration = PANDA.home + rng.normal(size=7) / 2, rng.normal(size=7), 3 * rng.normal(size=7)
    data.qpos[:], data.qvel[:], data.qacc[:] = q, velocity, acceleration
    mujoco.mj_inverse(loaded, data)
    dynamics = InverseDynamics(PANDA.kinematics)
    holding, moving = dynamics.torques(q[None], velocity[None], acceleration[None], load=LOAD_KG)
    assert holding[0] + moving[0] == pytest.approx(data.qfrc_inverse, abs=1e-6)
    data.qvel[:], data.qacc[:] = 0.0, 0.0
    mujoco.mj_inverse(loaded, data)
    assert holding[0] == pytest.approx(data.qfrc_inverse, abs=1e-6)
    inertia = np.empty((7, 7))
    mujoco.mj_crb(loaded, data)
    mujoco.mj_fullM(loaded, data, inertia)
    assert dynamics.inertia(q, load=LOAD_KG) == pytest.approx(inertia, abs=1e-6)


def test_a_stretched_arm_lifts_a_load_within_its_torque_limits_and_no_slower_than_that() -> None:
    arm = Arm(PANDA)
    low = np.array([0.76, 0.15, 0.015])
    start, goal = (arm.reach([ToolPose.down(low + [0, 0, up], 0.0)]) for up in (0.0, 0.12))
    empty, loaded = (arm.move(start[0], goal[0], goal[1], load=load).references for load in (0.0, LOAD_KG))
    assert len(empty) < len(loaded) < 2 * len(empty)
    rows = np.vstack([np.repeat(start[0][None], 2, axis=0), loaded, np.repeat(loaded[-1:], 2, axis=0)])
    speeds = np.diff(rows, axis=0) / CONTROL_PERIOD_S
    moved = rows[1:-1], (speeds[1:] + speeds[:-1]) / 2, np.diff(speeds, axis=0) / CONTROL_PERIOD_S
    shares = np.abs(np.sum(InverseDynamics(arm.model).torques(*moved, load=LOAD_KG), axis=0)) / PANDA.torque_limits
    assert 0.9 < shares.max() < 1.0
