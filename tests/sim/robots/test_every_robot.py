"""What holds for every robot: its tool, its fingers, and the skills. Menagerie's come from a repository made here."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np
import pytest
from skill_runs import assert_good

from prefplan.models.manipulation.model import ManipulationModel
from sim.execution.executor import execute
from sim.robots.arms import fetch
from sim.robots.catalogue import robot_named
from sim.robots.robot import Robot
from sim.world.scene import build_scene

from .test_menagerie import stand_in

NEEDS_MESHES = pytest.mark.skipif(fetch.unavailable_because() is not None, reason="its meshes are not installed")

SLIDING = ["panda", pytest.param("fetch", marks=NEEDS_MESHES), "menagerie"]
"""Robots whose fingers slide."""

LINKED = ["ur5e", "xarm7", "gen3"]
"""Robots whose fingers hang on a linkage, which follows a command less exactly."""


@pytest.fixture(scope="module", autouse=True)
def menagerie(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    with pytest.MonkeyPatch.context() as patch:
        yield stand_in(patch, tmp_path_factory.mktemp("menagerie"))


@pytest.fixture(scope="module", params=[*SLIDING, *LINKED])
def robot(request: pytest.FixtureRequest) -> Robot:
    return robot_named(request.param)


@pytest.fixture
def at_home(robot: Robot) -> mujoco.MjData:
    spec = robot.spec()
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data = mujoco.MjData(spec.compile())
    robot.put(data, robot.home, width=robot.gripper.opening_m)
    mujoco.mj_forward(data.model, data)
    return data


def test_the_tool_points_down_before_the_base_between_the_pads(robot: Robot, at_home: mujoco.MjData) -> None:
    tool, pads = at_home.site(robot.tool), [at_home.geom(pad).xpos for pad in robot.gripper.pads]
    assert tool.xmat[8] < -0.999
    assert tool.xpos[0] > 0.2 and tool.xpos[2] > 0.05
    assert np.mean(pads, axis=0)[:2] == pytest.approx(tool.xpos[:2], abs=0.002)
    assert at_home.ncon == 0, "no part of the robot should touch another"


def test_the_fingers_close_along_y_to_the_commanded_width_and_the_arm_holds_its_pose(
    robot: Robot, at_home: mujoco.MjData
) -> None:
    gripper, model = robot.gripper, at_home.model
    exact = 0.003 if robot.name in LINKED else 0.001
    for width in (0.08, 0.045, 0.02):
        at_home.actuator(gripper.actuator).ctrl[0] = gripper.command(width)
        mujoco.mj_step(model, at_home, 500)
        tool = at_home.site(robot.tool)
        pads = np.array([at_home.geom(pad).xpos for pad in gripper.pads]) - tool.xpos
        across = pads @ tool.xmat.reshape(3, 3)[:, 1]
        thickness = sum(model.geom(pad).size[1] for pad in gripper.pads)
        assert abs(across[0] - across[1]) - thickness == pytest.approx(width, abs=exact)
        assert abs(across.sum()) < exact / 2, "the tool is in the middle"
        fingers = np.array([at_home.joint(name).qpos[0] for name in gripper.joints])
        assert gripper.opened(fingers) == pytest.approx(width, abs=exact)
        assert fingers == pytest.approx(gripper.positions(width), abs=0.05)
    assert at_home.qpos[robot.qpos(model)] == pytest.approx(robot.home, abs=1e-3)


def test_the_same_skills_work(robot: Robot, arch_model: ManipulationModel) -> None:
    actions = ["transit top", "grasp pink", "transport pink bin1", "release pink bin1"]
    rollout = execute(build_scene(arch_model, robot=robot), actions, seed=1)
    assert_good(rollout)
    assert rollout.placement_error < (0.004 if robot.name in LINKED else 0.002)
