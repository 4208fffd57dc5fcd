"""Kinova's Gen3 with seven joints and a Robotiq 2F-85."""

from __future__ import annotations

import numpy as np

from sim.robots.menagerie.arm import MenagerieArm, menagerie_robot
from sim.robots.menagerie.robotiq_2f85 import robotiq_2f85

GEN3 = menagerie_robot(
    MenagerieArm(
        name="gen3",
        title="Kinova Gen3 with a Robotiq 2F-85",
        description="gen3_mj_description",
        base="base_link",
        joints=tuple(f"joint_{i}" for i in range(1, 8)),
        # Kinova's ros2_kortex, kortex_description: velocities of the four large and the three small actuators.
        velocity=(1.3963,) * 4 + (1.2218,) * 3,
        # Menagerie's force limits: the actuators' peaks.
        torque=(105.0,) * 4 + (52.0,) * 3,
        home=(0.0, 0.26, np.pi, -2.27, 0.0, 0.96 - np.pi / 2, np.pi / 2),
        hand=robotiq_2f85("bracelet_link", (0.0, 0.0, -0.061525), (0.0, 1.0, 0.0, 0.0)),
        # Kinova's user guide, for the middle of its reach.
        payload_kg=4.0,
        nearest_m=0.25,
    )
)
