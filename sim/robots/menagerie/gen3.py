"""Kinova's Gen3 of seven joints with a Robotiq 2F-85."""

from __future__ import annotations

import numpy as np

from sim.robots.menagerie import robotiq_2f85
from sim.robots.menagerie.arm import MenagerieArm, menagerie_robot

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
        tool=robotiq_2f85.TOOL,
        tool_m=robotiq_2f85.TOOL_M,
        actuator=robotiq_2f85.ACTUATOR,
        opening_m=robotiq_2f85.OPENING_M,
        force_n=robotiq_2f85.FORCE_N,
        # Kinova's user guide: in the middle of its range.
        payload_kg=4.0,
        nearest_m=0.25,
        hand=robotiq_2f85.on("bracelet_link", (0.0, 0.0, -0.061525), (0.0, 1.0, 0.0, 0.0)),
    )
)
