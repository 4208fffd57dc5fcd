from __future__ import annotations

from contextlib import suppress

import mujoco
import numpy as np
import pytest

from sim.errors import SimulationError
from sim.motion.kinematics import Arm
from sim.motion.trajectory import CONTROL_PERIOD_S, ToolPose, duration, smooth_step, transfer_path, wrap
from sim.robots.arms.panda import PANDA

PLACES = [(0.50, 0.0, 0.07), (0.45, 0.30, 0.03), (0.38, -0.30, 0.15), (0.75, 0.2, 0.03), (-0.2, 0.5, 0.05)]


@pytest.fixture(scope="module")
def arm() -> Arm:
    return Arm(PANDA)


def test_wrap_is_the_nearest_equivalent() -> None:
    assert wrap(1.5 * np.pi) == pytest.approx(-0.5 * np.pi)
    assert wrap(np.radians(80), np.pi / 2) == pytest.approx(np.radians(-10))


def test_smooth_step_keeps_to_speed_and_acceleration() -> None:
    length, speed, acceleration = 0.3, 0.5, 2.0
    t = np.linspace(0, duration(length, speed, acceleration), 2001)
    velocity = np.gradient(length * smooth_step(t / t[-1]), t)
    assert velocity.max() <= speed * 1.001
    assert np.abs(np.gradient(velocity, t)).max() <= acceleration * 1.01
    assert abs(velocity[0]) < 1e-3 and abs(velocity[-1]) < 1e-3


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("yaw", np.radians([0, 45, 90, 100, 150]))
def test_reach_points_the_tool_down_at_the_goal(arm: Arm, place: tuple[float, float, float], yaw: float) -> None:
    q, taken = arm.reach(ToolPose.down(np.array(place), yaw).symmetric_poses())
    tool = arm.tool(q)
    assert np.linalg.norm(tool.position - place) < 0.001
    assert abs(wrap(tool.yaw - taken.yaw)) < 0.005
    assert abs(wrap(tool.yaw - yaw, np.pi)) < 0.005
    if place[0] > 0:
        assert abs(q[6]) <= np.pi / 2 + 1e-3, "the last joint should keep off its stops"


def test_reach_refuses_what_is_out_of_reach(arm: Arm) -> None:
    with pytest.raises(SimulationError, match=r"cannot point down at \(1\.100, 0\.000, 0\.050\)"):
        arm.reach([ToolPose.down(np.array([1.1, 0.0, 0.05]), 0.0)])


def test_arch_rises_straight_clears_the_height_and_comes_down_straight() -> None:
    start, goal = ToolPose.down(np.array([0.5, 0.2, 0.05]), 0.0), ToolPose.down(np.array([0.4, -0.3, 0.08]), 1.0)
    path = transfer_path(PANDA, start, goal, 1.0, height=0.3)
    p = path.positions
    near = np.hypot(*(p - start.position)[:, :2].T) < 0.05
    far = np.hypot(*(p - goal.position)[:, :2].T) < 0.05
    assert p[~near & ~far, 2].min() > 0.25
    assert np.abs(p[:7, :2] - start.position[:2]).max() < 0.001
    assert np.allclose(p[-1], goal.position) and np.allclose(path.rotations[-1], goal.rotation)
    assert np.abs(p[-4:, :2] - goal.position[:2]).max() < 0.001


def test_arch_never_cuts_across_the_base() -> None:
    start, goal = ToolPose.down(np.array([-0.2, 0.45, 0.2]), 0.0), ToolPose.down(np.array([-0.2, -0.45, 0.2]), 0.0)
    p = transfer_path(PANDA, start, goal, 0.0, height=0.0).positions
    assert np.hypot(p[:, 0], p[:, 1]).min() > 0.45
    assert p[:, 0].max() > 0.45, "it should turn past the front"


def test_movements_keep_every_joint_within_its_limits(arm: Arm) -> None:
    low, high = arm.model.jnt_range.T
    q = PANDA.home
    for place in PLACES:
        position = np.array(place)
        goal, pose = arm.reach(ToolPose.down(position, 0.3).symmetric_poses())
        references = arm.move(q, goal, pose, height=0.2).references
        speeds = np.diff(references, axis=0, prepend=q[None]) / CONTROL_PERIOD_S
        assert (np.abs(speeds) <= PANDA.velocity_limits).all()
        assert np.abs(speeds[[0, -1]]).max() < 0.05, "it should start and end at rest"
        assert np.abs(np.diff(speeds, axis=0) / CONTROL_PERIOD_S).max() < 15, "accelerations should be smooth"
        assert (references > low).all() and (references < high).all()
        assert np.linalg.norm(arm.tool(references[-1]).position - position) < 0.001
        q = references[-1]


def test_no_movement_is_much_slower_than_its_length_warrants(arm: Arm) -> None:
    rng, (low, high), done = np.random.default_rng(0), PANDA.ranges(arm.model).T, 0
    for _ in range(400):
        q = np.clip(PANDA.home + rng.normal(scale=0.4, size=7), low + 0.1, high - 0.1)
        position = np.array([rng.uniform(0.35, 0.65), rng.uniform(-0.4, 0.4), 0.15])
        goal, pose = arm.reach(ToolPose.down(position, rng.uniform(-1.5, 1.5)).symmetric_poses())
        with suppress(SimulationError):
            assert arm.move(q, goal, pose, height=0.5, drawn_in=0.15).seconds < 6.0
            done += 1
    assert done > 390


@pytest.mark.parametrize(
    "aside", [[0.18, -0.64, 0.96, -3.06, 0.88, 2.45, -2.07], [2.88, -0.64, -0.97, -3.04, -0.87, 2.44, -0.72]]
)
def test_near_the_base_the_hand_comes_down_although_the_elbow_has_swung_aside(arm: Arm, aside: list[float]) -> None:
    above = arm.tool(np.array(aside))
    goal, pose = arm.reach([ToolPose.down(above.position - [0.0, 0.0, 0.12], above.yaw)])
    references = arm.move(np.array(aside), goal, pose).references
    low, high = arm.model.jnt_range.T
    assert (references > low).all() and (references < high).all()
    tools = np.array([arm.tool(q).position for q in references])
    assert tools[-1] == pytest.approx(pose.position, abs=0.001)
    assert np.hypot(*(tools - pose.position)[:, :2].T).max() < 0.015


def test_the_elbow_does_not_wander(arm: Arm) -> None:
    there, _ = arm.reach(ToolPose.down(np.array(PLACES[1]), 0.0).symmetric_poses())
    q = PANDA.home
    for place in (PLACES[0], PLACES[2], PLACES[1]) * 3:
        goal, pose = arm.reach(ToolPose.down(np.array(place), 0.0).symmetric_poses())
        q = arm.move(q, goal, pose, height=0.2).positions[-1]
    assert np.abs(q - there).max() < 0.01


def test_the_tool_stays_upright_on_the_way(arm: Arm) -> None:
    position = np.array(PLACES[2])
    goal, pose = arm.reach(ToolPose.down(position, np.pi / 2).symmetric_poses())
    data = mujoco.MjData(arm.model)
    for q in arm.move(PANDA.home, goal, pose, height=0.2).references[::10]:
        data.qpos[:] = q
        mujoco.mj_kinematics(arm.model, data)
        assert data.site("tcp").xmat[8] < -np.cos(np.radians(1))


def test_from_high_up_the_tool_comes_down_on_its_way_out() -> None:
    start, goal = ToolPose.down(np.array([0.3, 0.0, 0.5]), 0.0), ToolPose.down(np.array([0.7, 0.0, 0.1]), 0.0)
    path = transfer_path(PANDA, start, goal, 0.0, height=0.2)
    halfway = path.positions[np.searchsorted(path.positions[:, 0], 0.5)]
    assert halfway[2] == pytest.approx(0.35, abs=0.01)
    straight = transfer_path(PANDA, start, goal, 0.0)
    assert straight.positions[np.searchsorted(straight.positions[:, 0], 0.5)][2] == pytest.approx(0.5)
    assert path.positions[-1] == pytest.approx(goal.position) and straight.positions[-1] == pytest.approx(goal.position)


def test_a_path_drawn_in_passes_nearer_to_the_base_but_not_too_near() -> None:
    start, goal = ToolPose.down(np.array([0.6, 0.2, 0.2]), 0.0), ToolPose.down(np.array([0.6, -0.2, 0.2]), 0.0)
    end = float(np.hypot(0.6, 0.2))
    for drawn_in, nearest in ((0.0, end), (0.15, end - 0.15), (0.5, 0.32)):
        radii = np.hypot(*transfer_path(PANDA, start, goal, 0.0, drawn_in=drawn_in).positions[:, :2].T)
        assert radii.min() == pytest.approx(nearest, abs=1e-3)
        assert radii[-1] == pytest.approx(end)
