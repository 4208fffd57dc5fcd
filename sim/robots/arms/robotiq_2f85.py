"""The Robotiq 2F-85, which is mounted on arms without a hand of their own."""

from collections.abc import Sequence

import mujoco

from prefplan.models.manipulation.surroundings import GripperSetup
from sim.robots.menagerie import menagerie_mjcf
from sim.robots.robot import check_parts

HAND = "hand_"
"""Prefix of the names of the hand."""

TOOL = "tool"
"""Name of the site of the tool."""

# Robotiq's data sheet: stroke, and a force that is adjustable from 20 to 235 N.
ROBOTIQ_2F85 = GripperSetup("parallel", f"{HAND}fingers_actuator", force=40.0, open=0.085)


def with_robotiq(arm: mujoco.MjSpec, flange: str, pos: Sequence[float], quat: Sequence[float]) -> mujoco.MjSpec:
    """Return an arm of Menagerie with the hand on its flange; `pos`, m, and `quat` are its pose on the flange."""
    hand = menagerie_mjcf("robotiq_2f85_mj_description")
    check_parts(arm, body=(flange,))
    check_parts(hand, body=("base_mount", "base"))
    hand.option = arm.option
    arm.body(flange).add_frame(pos=pos, quat=quat).attach_body(hand.body("base_mount"), HAND, "")
    # The middle of the closing pads.
    arm.body(f"{HAND}base").add_site(name=TOOL, pos=[0, 0, 0.150])
    return arm
