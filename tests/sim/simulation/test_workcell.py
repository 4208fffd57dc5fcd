from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from observers import Before

from sim.errors import SimulationError, UnstableError
from sim.execution.executor import Execution
from sim.motion.ik import JOINT_MARGIN_RAD
from sim.motion.trajectory import ToolPose
from sim.robots.arms.panda import PANDA
from sim.simulation.recorder import COMMANDS_PER_UNIT
from sim.simulation.workcell import Workcell
from sim.skills.catalogue import perform
from sim.skills.hand import move_tool
from sim.world.scene import Scene, initial_state

REST_SPEED_RAD_S = 0.02
"""The arm rests while every joint is slower than this (at 0.5 m that is 1 cm/s)."""


@pytest.fixture
def cell(scene: Scene) -> Workcell:
    return Workcell(scene, initial_state(scene))


def test_an_arm_at_rest_takes_time_alone(cell: Workcell) -> None:
    cell.wait(0.5)
    assert cell.effort.time == pytest.approx(0.5)
    assert cell.effort.travel < 0.01 and cell.effort.energy < 0.1


def test_travel_is_the_angle_covered(cell: Workcell) -> None:
    perform(cell, "transit table")
    angles = cell.recorder.arrays["qpos"][:, PANDA.qpos(cell.scene.mujoco)]
    assert cell.effort.travel == pytest.approx(np.abs(np.diff(angles, axis=0)).sum(), rel=0.03)


def test_energy_is_at_least_the_work_done_against_gravity(cell: Workcell) -> None:
    data, model = cell.data, cell.scene.mujoco
    low, high = ([*cell.scene.slots["table"][0].position[:2], z] for z in (0.10, 0.45))
    heights, spent = [], []
    for point in (low, high):
        goal, pose = cell.arm.reach(ToolPose.down(np.array(point), 0.0).symmetric_poses())
        cell.follow(cell.arm.move(cell.reference, goal, pose, height=0.0))
        cell.wait(0.5)
        links = [i for i in range(model.nbody) if model.body_gravcomp[i] > 0]
        heights.append(-model.opt.gravity[2] * sum(model.body_mass[i] * data.xipos[i][2] for i in links))
        spent.append(cell.effort.energy)
    assert heights[1] - heights[0] > 5
    assert spent[1] - spent[0] > heights[1] - heights[0]


def test_the_next_movement_begins_before_the_arm_rests_and_leads_to_its_goal(cell: Workcell) -> None:
    data, speeds = cell.data, []
    low, high = (np.array([0.5, 0.1, z]) for z in (0.15, 0.35))
    move_tool(cell, ToolPose.down(high, 0.0), within=0.02)
    assert 0 < np.linalg.norm(data.site("tcp").xpos - high) < 0.025 and len(cell.ending)
    Before(cell, lambda: speeds.append(np.abs(data.qvel[:7]).max()))
    move_tool(cell, ToolPose.down(low, 0.0))
    assert np.linalg.norm(data.site("tcp").xpos - low) < 0.002 and not len(cell.ending)
    assert min(speeds[: len(speeds) // 2]) > REST_SPEED_RAD_S
    recorded = cell.recorder.arrays
    assert all((recorded[load] < limits).all() for load, limits in PANDA.load_limits.items())


def test_an_arm_brakes_smoothly_beside_a_joints_position_limit(cell: Workcell) -> None:
    goal, low = PANDA.home.copy(), PANDA.ranges(cell.scene.mujoco)[3, 0]
    goal[3] = low + 1.1 * JOINT_MARGIN_RAD
    cell.follow(cell.arm.move(cell.reference, goal, cell.arm.tool(goal)))
    recorded = cell.recorder.arrays
    assert recorded["controls"][:, 3].min() / COMMANDS_PER_UNIT < low, "commands lead the joint"
    assert (recorded["torque_rates"] / PANDA.torque_rate_limits).max() < 0.1


def test_a_surprise_on_the_way_brakes_the_arm_within_its_limits(cell: Workcell) -> None:
    goal = np.array([0.5, 0.2, 0.35])

    def watch() -> None:
        if cell.data.time > 0.5:
            raise SimulationError("surprise")

    with pytest.raises(SimulationError, match="surprise"):
        move_tool(cell, ToolPose.down(goal, 0.0), watch=watch)
    assert 0.5 < cell.data.time < 1.0 and not len(cell.ending)
    assert np.abs(cell.data.qvel[:7]).max() < REST_SPEED_RAD_S
    assert np.linalg.norm(cell.data.site("tcp").xpos - goal) > 0.02
    assert cell.angles == pytest.approx(cell.reference, abs=0.002)
    recorded = cell.recorder.arrays
    assert all((recorded[load] < limits).all() for load, limits in PANDA.load_limits.items())


def test_a_step_tells_its_own_effort(scene: Scene) -> None:
    run = Execution(scene, initial_state(scene))
    run.step("transit top")
    run.step("grasp pink")
    first, second = (step.effort for step in run.steps)
    assert (first + second).energy == pytest.approx(run.cell.effort.energy)
    assert second.time == pytest.approx(run.steps[1].end - run.steps[1].start)
    assert 0 < second.travel and 0 < second.energy


def test_the_actuators_get_a_command_after_the_latency(scene: Scene) -> None:
    finger, moved = PANDA.gripper.joints[0], []
    for latency in (0.0, 0.1):
        cell = Workcell(replace(scene, latency=latency), initial_state(scene))
        before = cell.data.joint(finger).qpos[0]
        cell.set_width(cell.width - 0.02, 0.0)
        for wait in (0.09, 0.2):
            cell.wait(wait)
            moved.append(abs(float(cell.data.joint(finger).qpos[0]) - before))
    at_once, _, late, in_the_end = moved
    assert at_once > 0.001 > 1e-4 > late and in_the_end == pytest.approx(0.01, abs=0.001)


@pytest.mark.parametrize("speed", [np.nan, 1e12])
def test_a_simulation_that_diverges_ends_the_run(
    scene: Scene, speed: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo leaves a file of its warning there
    run = Execution(scene, initial_state(scene))

    def disturb() -> None:
        if run.cell.data.time > 0.5:
            run.cell.data.joint("blue").qvel[:] = speed

    Before(run.cell, disturb)
    with pytest.raises(UnstableError, match=r"the simulation became unstable at 0\.5. s"):
        run.step("transit top")
