"""Universal Robots' UR5e with a Robotiq 2F-85."""

from __future__ import annotations

import numpy as np

from sim.robots.menagerie.arm import MenagerieArm, menagerie_robot
from sim.robots.menagerie.robotiq_2f85 import robotiq_2f85

UR5E = menagerie_robot(
    MenagerieArm(
        name="ur5e",
        title="Universal Robots UR5e with a Robotiq 2F-85",
        description="ur5e_mj_description",
        base="base",
        joints=(
            "shoulder_pan_joint",
            "shoulder_lift_joint",
            "elbow_joint",
            "wrist_1_joint",
            "wrist_2_joint",
            "wrist_3_joint",
        ),
        # Universal Robots' data sheet: 180 degrees a second in every joint; "Max. joint torques" on its support site.
        velocity=(np.pi,) * 6,
        torque=(150.0, 150.0, 150.0, 28.0, 28.0, 28.0),
        # The elbow up, the hand down in front of the base, which Menagerie rotates by 90 degrees.
        home=(-np.pi / 2, -np.pi / 2, np.pi / 2, -np.pi / 2, -np.pi / 2, 0.0),
        hand=robotiq_2f85("wrist_3_link", (0.0, 0.1, 0.0), (-1.0, 1.0, 0.0, 0.0)),
        # Universal Robots' data sheet.
        payload_kg=5.0,
        # Nearer to the axis, the elbow would have to fold beyond the upper arm.
        nearest_m=0.28,
    )
)
