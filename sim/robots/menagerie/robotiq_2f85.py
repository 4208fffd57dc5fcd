"""Constants of the Robotiq 2F-85, which is mounted on arms without a hand of their own."""

from __future__ import annotations

from sim.robots.menagerie.arm import HAND, Mounted, Quaternion, Triple

TOOL, TOOL_M = f"{HAND}base", 0.150
"""Body of the tool's frame, and the middle of the closing pads along its z, m."""

ACTUATOR = f"{HAND}fingers_actuator"

OPENING_M = 0.085
"""Robotiq's data sheet: stroke."""

FORCE_N = 40.0
"""Of each pad; Robotiq's data sheet has 20 to 235 N to choose from."""


def on(flange: str, pos: Triple, quat: Quaternion) -> Mounted:
    """Return the hand on a body of an arm."""
    return Mounted("robotiq_2f85_mj_description", "base_mount", flange, pos, quat)
