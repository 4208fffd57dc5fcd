"""Universal Robots' UR5e with a Robotiq 2F-85."""

import mujoco
import numpy as np

from sim.robots.arms.robotiq_2f85 import ROBOTIQ_2F85, TOOL, with_robotiq
from sim.robots.import_mjcf import ImportedArm
from sim.robots.menagerie import menagerie_mjcf, unavailable_because


def ur5e_mjcf() -> mujoco.MjSpec:
    """Return the arm with its hand."""
    return with_robotiq(menagerie_mjcf("ur5e_mj_description"), "wrist_3_link", (0.0, 0.1, 0.0), (-1.0, 1.0, 0.0, 0.0))


UR5E = ImportedArm(
    "ur5e",
    title="Universal Robots UR5e with a Robotiq 2F-85",
    mjcf=ur5e_mjcf,
    unavailable_because=unavailable_because,
    joints=(
        "shoulder_pan_joint",
        "shoulder_lift_joint",
        "elbow_joint",
        "wrist_1_joint",
        "wrist_2_joint",
        "wrist_3_joint",
    ),
    # Universal Robots' data sheet: 180 degrees a second in every joint; "Max. joint torques" on its support site.
    velocity_limits=np.full(6, np.pi),
    torque_limits=np.array([150.0, 150.0, 150.0, 28.0, 28.0, 28.0]),
    # The elbow up, the hand down in front of the base, which Menagerie rotates by 90 degrees.
    home=np.array([-np.pi / 2, -np.pi / 2, np.pi / 2, -np.pi / 2, -np.pi / 2, 0.0]),
    tool=TOOL,
    gripper=ROBOTIQ_2F85,
    # Universal Robots' data sheet.
    payload_kg=5.0,
    # Nearer to the axis, the elbow would have to fold beyond the upper arm.
    nearest_m=0.28,
)
