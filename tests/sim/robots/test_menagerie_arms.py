"""Menagerie's UR5e, xArm7 and Gen3: on a git repository made here that stands in for the real one."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from prefplan.models.manipulation.model import ManipulationModel
from sim.execution.executor import execute
from sim.robots.adapted import PREFIX
from sim.robots.catalogue import robot_named
from sim.robots.robot import Robot
from sim.simulation.rollout import Rollout
from sim.world.scene import build_scene

from .test_menagerie import stand_in

ARMS = ("ur5e", "xarm7", "gen3")


@pytest.fixture(scope="module", autouse=True)
def menagerie(tmp_path_factory: pytest.TempPathFactory) -> object:
    with pytest.MonkeyPatch.context() as patch:
        yield stand_in(patch, tmp_path_factory.mktemp("menagerie"))


@pytest.fixture(scope="module", params=ARMS)
def robot(request: pytest.FixtureRequest, menagerie: Path) -> Robot:
    return robot_named(request.param)


@pytest.fixture
def at_home(robot: Robot) -> mujoco.MjData:
    spec = robot.spec()
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data = mujoco.MjData(spec.compile())
    robot.put(data, robot.home, width=robot.gripper.opening_m)
    mujoco.mj_forward(data.model, data)
    return data


def test_the_tool_points_down_before_the_base(robot: Robot, at_home: mujoco.MjData) -> None:
    tool = at_home.site(robot.tool)
    assert tool.xmat[8] < -0.999
    assert tool.xpos[0] > 0.2 and tool.xpos[2] > 0.05


def test_the_linkage_follows_the_commanded_width(robot: Robot, at_home: mujoco.MjData) -> None:
    gripper, model = robot.gripper, at_home.model
    for width in (0.08, 0.045, 0.02):
        at_home.actuator(gripper.actuator).ctrl[0] = gripper.command(width)
        mujoco.mj_step(model, at_home, 500)
        tool = at_home.site(robot.tool)
        pads = np.array([at_home.geom(pad).xpos for pad in gripper.pads]) - tool.xpos
        across = pads @ tool.xmat.reshape(3, 3)[:, 1]
        thickness = sum(model.geom(pad).size[1] for pad in gripper.pads)
        assert abs(across[0] - across[1]) - thickness == pytest.approx(width, abs=0.003)
        assert abs(across.sum()) < 0.002, "the tool is in the middle"
        fingers = np.array([at_home.joint(name).qpos[0] for name in gripper.joints])
        assert gripper.opened(fingers) == pytest.approx(width, abs=0.002)
        assert fingers == pytest.approx(gripper.positions(width), abs=0.05)
    assert at_home.qpos[robot.qpos(model)] == pytest.approx(robot.home, abs=1e-3)


def test_the_same_skills_work(robot: Robot, arch_model: ManipulationModel) -> None:
    actions = ["transit top", "grasp pink", "transport pink bin1", "release pink bin1"]
    rollout: Rollout = execute(build_scene(arch_model, robot=robot), actions, seed=1)
    assert rollout.completed, rollout.reason
    assert rollout.placement_error < 0.004
    assert max(float(share.max()) for share in rollout.load_shares.values()) < 1
    assert all(name.startswith(PREFIX) for name in robot.joints)
