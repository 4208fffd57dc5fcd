"""UFACTORY's xArm7 with its own gripper."""

from __future__ import annotations

import numpy as np

from sim.robots.menagerie.arm import MenagerieArm, MenagerieHand, menagerie_robot

XARM7 = menagerie_robot(
    MenagerieArm(
        name="xarm7",
        title="UFACTORY xArm7 with its gripper",
        description="xarm7_mj_description",
        base="link_base",
        joints=tuple(f"joint{i}" for i in range(1, 8)),
        # UFACTORY's data sheet: 180 degrees a second in every joint; torques are Menagerie's force limits.
        velocity=(np.pi,) * 7,
        torque=(50.0, 50.0, 30.0, 30.0, 30.0, 20.0, 20.0),
        home=(0.0, -0.247, 0.0, 0.909, 0.0, 1.156, 0.0),
        hand=MenagerieHand(
            tool="xarm_gripper_base_link",
            # Between the middles of the upper and the lower pad of a finger when they hold a block.
            tool_m=0.155,
            actuator="gripper",
            # UFACTORY's data sheet: stroke 84 mm, 30 N.
            opening_m=0.084,
            force_n=30.0,
        ),
        payload_kg=3.5,
        nearest_m=0.25,
    )
)
