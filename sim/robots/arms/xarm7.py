"""UFACTORY's xArm7 with its own gripper."""

import mujoco
import numpy as np

from prefplan.models.manipulation.surroundings import GripperSetup
from sim.robots.import_mjcf import ImportedArm
from sim.robots.menagerie import menagerie_mjcf, unavailable_because
from sim.robots.robot import check_parts


def xarm7_mjcf() -> mujoco.MjSpec:
    """Return the arm with the site of the tool."""
    arm = menagerie_mjcf("xarm7_mj_description")
    check_parts(arm, body=("xarm_gripper_base_link",))
    # Between the middles of the upper and the lower pad of a finger when they hold a block.
    arm.body("xarm_gripper_base_link").add_site(name="tool", pos=[0, 0, 0.155])
    return arm


XARM7 = ImportedArm(
    "xarm7",
    title="UFACTORY xArm7 with its gripper",
    mjcf=xarm7_mjcf,
    unavailable_because=unavailable_because,
    joints=tuple(f"joint{i}" for i in range(1, 8)),
    # UFACTORY's data sheet: 180 degrees a second in every joint; torques are Menagerie's force limits.
    velocity_limits=np.full(7, np.pi),
    torque_limits=np.array([50.0, 50.0, 30.0, 30.0, 30.0, 20.0, 20.0]),
    home=np.array([0.0, -0.247, 0.0, 0.909, 0.0, 1.156, 0.0]),
    tool="tool",
    # UFACTORY's data sheet: stroke 84 mm, 30 N.
    gripper=GripperSetup("parallel", "gripper", force=30.0, open=0.084),
    payload_kg=3.5,
    nearest_m=0.25,
)
