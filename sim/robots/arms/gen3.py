"""Kinova's Gen3 with seven joints and a Robotiq 2F-85."""

import mujoco
import numpy as np

from sim.robots.arms.robotiq_2f85 import ROBOTIQ_2F85, TOOL, with_robotiq
from sim.robots.import_mjcf import ImportedArm
from sim.robots.menagerie import menagerie_mjcf, unavailable_because


def gen3_mjcf() -> mujoco.MjSpec:
    """Return the arm with its hand."""
    arm = menagerie_mjcf("gen3_mj_description")
    return with_robotiq(arm, "bracelet_link", (0.0, 0.0, -0.061525), (0.0, 1.0, 0.0, 0.0))


GEN3 = ImportedArm(
    "gen3",
    title="Kinova Gen3 with a Robotiq 2F-85",
    mjcf=gen3_mjcf,
    unavailable_because=unavailable_because,
    joints=tuple(f"joint_{i}" for i in range(1, 8)),
    # Kinova's ros2_kortex, kortex_description: velocities of the four large and the three small actuators.
    velocity_limits=np.array([1.3963] * 4 + [1.2218] * 3),
    # Menagerie's force limits: the actuators' peaks.
    torque_limits=np.array([105.0] * 4 + [52.0] * 3),
    home=np.array([0.0, 0.26, np.pi, -2.27, 0.0, 0.96 - np.pi / 2, np.pi / 2]),
    tool=TOOL,
    gripper=ROBOTIQ_2F85,
    # Kinova's user guide, for the middle of its reach.
    payload_kg=4.0,
    nearest_m=0.25,
)
