"""The Panda with a suction cup on its hand instead of fingers."""

from dataclasses import replace

import mujoco

from sim.robots.arms.panda import MJCF, PANDA, panda_spec
from sim.robots.gripper import SUCTION_OPENING_M, SUCTION_SQUEEZE_M, SuctionGripper

FORCE_N = 27.1434
"""Suction force, N: 60 kPa below air pressure, typical of an ejector, at a lip of 24 mm in diameter."""


def suction_spec() -> mujoco.MjSpec:
    """Return the robot; raise the errors of `panda_spec`."""
    spec = panda_spec()
    for name in ("left_finger", "right_finger"):
        spec.delete(spec.body(name))  # and what moves it
    cup = mujoco.MjSpec.from_file(str(MJCF.with_name("suction_cup.xml")))
    cup.option = spec.option
    spec.body("hand").add_frame(pos=spec.site(PANDA.tool).pos).attach_body(cup.body("cup"), "suction_", "")
    return spec


PANDA_SUCTION = replace(
    PANDA,
    name="panda_suction",
    title="the same arm with a suction cup",
    mjcf=suction_spec,
    # Its payload is that of the arm; what the cup holds depends on the object's height (`Gripper.held_mass`).
    gripper=SuctionGripper(
        actuator="suction_gripper",
        joints=("suction_cup",),
        pads=("suction_cup",),
        opening_m=SUCTION_OPENING_M,
        squeeze_m=SUCTION_SQUEEZE_M,
        # About a fifth of its force.
        firm_force_n=5.0,
        # The lip, with 2 mm of clearance.
        finger_depth_m=0.014,
        finger_half_width_m=0.014,
        fingertip_m=0.0,
        # From the lip to the hand, with 2 mm of clearance.
        palm_height_m=0.035,
        palm_half_width_m=0.034,
        force_n=FORCE_N,
    ),
)
