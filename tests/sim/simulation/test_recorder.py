from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sim.execution.executor import execute
from sim.motion.kinematics import Arm
from sim.motion.trajectory import ToolPose
from sim.robots.arms.panda import PANDA
from sim.simulation.recorder import Recorder, missed_contacts
from sim.simulation.run import Run
from sim.world.scene import Scene, initial_state


@pytest.fixture(scope="module")
def grasp(scene: Scene) -> Run:
    return execute(scene, ["transit top", "grasp pink"])


def test_the_greatest_load_between_two_frames_and_after_the_last_is_kept(scene: Scene) -> None:
    data, recorder = initial_state(scene), Recorder(scene)
    recorder.record(data, glow=-1)
    period, times = scene.mujoco.opt.timestep, np.arange(5) * scene.mujoco.opt.timestep
    motors = [scene.mujoco.actuator(name).id for name in PANDA.joints]
    stiffness, damping = -scene.mujoco.actuator_biasprm[motors, 1:3].T
    controls = np.zeros((5, scene.mujoco.nu))
    controls[:, motors] = 5000.0 * times[:, None] ** 3 + damping / stiffness * 15000.0 * times[:, None] ** 2
    recorder.begin_period(data, controls)
    for speed in (0.5, -2.0, 1.0, 1.0):
        data.joint("joint2").qvel[0] = speed
        mujoco.mj_forward(scene.mujoco, data)
        recorder.feel(data)
    recorder.record(data, glow=-1)
    data.joint("joint2").qvel[0] = 0.25
    data.ctrl[:] = 0
    mujoco.mj_forward(scene.mujoco, data)
    recorder.feel(data)
    loads = recorder.arrays
    assert loads["speeds"][:, 1].tolist() == [0, 2.0]
    assert loads["accelerations"][:, 1] == pytest.approx([0, 3.0 / period])
    assert loads["jerks"][:, 1] == pytest.approx([0, 30000.0], rel=0.01)
    torque = loads["torques"][1, 1]
    assert 0 < loads["torque_rates"][1, 1] <= 2 * torque / period
    assert loads["torques"].shape == (2, 7) and (loads["torques"][1] / PANDA.torque_limits).max() > 0.9


def test_whatever_presses_a_pad_is_felt(scene: Scene) -> None:
    data, recorder = initial_state(scene), Recorder(scene)
    recorder.record(data, glow=-1)
    q, _ = Arm(PANDA).reach(ToolPose.down(np.array([0.50, 0.0, 0.0675]), 0.0).symmetric_poses())
    PANDA.put(data, q, width=0.044)
    data.actuator(PANDA.gripper.actuator).ctrl[0] = 0.0
    mujoco.mj_forward(scene.mujoco, data)
    recorder.record(data, glow=-1)
    forces = recorder.arrays["pad_forces"]
    assert forces[0].tolist() == [0, 0] and forces[1].min() > 0.5


def test_a_rollout_holds_the_loads_of_every_frame(grasp: Run) -> None:
    frames = len(grasp.times)
    assert grasp.loads["speeds"].shape == grasp.loads["torques"].shape == (frames, 7) and grasp.pad_forces.shape == (
        frames,
        2,
    )
    shares = {name: share.max() for name, share in grasp.load_shares.items()}
    assert len(shares) == 5 and all(0.01 < share < 1 for share in shares.values()), shares
    assert np.median(grasp.pad_forces[-10:], axis=0) == pytest.approx([15, 15], abs=2)
    assert not grasp.pad_forces[grasp.times < grasp.steps[0].end].any()


@pytest.mark.parametrize(
    ("touching", "missed"),
    [
        ([2, 2, 1, 2, 2, 2, 2, 2], [2, 3, 4, 5]),
        ([2, 2, 1, 1, 2, 2, 2, 2], [2, 3, 4, 5, 6]),
        ([2, 2, 1, 1, 1, 2, 2, 2], []),  # lost for too long
        ([2, 2, 0, 2, 2, 2, 2, 2], []),  # by both pads
        ([0, 0, 1, 2, 2, 2, 2, 2], []),  # touched by one pad first
        ([2, 2, 1, 0, 0, 0, 0, 0], []),  # let go by one pad first
        ([2, 1], []),
        ([], []),
    ],
)
def test_a_pad_that_loses_contact_for_a_step_or_two_did_not_lose_it(touching: list[int], missed: list[int]) -> None:
    assert np.flatnonzero(missed_contacts(np.array(touching, dtype=int), 2)).tolist() == missed
    assert not missed_contacts(np.array(touching, dtype=int), 3).any()
