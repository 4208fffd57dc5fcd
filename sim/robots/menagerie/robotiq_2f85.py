"""The Robotiq 2F-85, which is mounted on arms without a hand of their own."""

from __future__ import annotations

from sim.robots.menagerie.arm import HAND, MenagerieHand, Mounted


def robotiq_2f85(
    flange: str, pos: tuple[float, float, float], quat: tuple[float, float, float, float]
) -> MenagerieHand:
    """Return the hand, mounted on a body of an arm at a position, m, and orientation in that body's frame."""
    return MenagerieHand(
        # The middle of the closing pads.
        tool=f"{HAND}base",
        tool_m=0.150,
        actuator=f"{HAND}fingers_actuator",
        # Robotiq's data sheet: stroke, and a force that is adjustable from 20 to 235 N.
        opening_m=0.085,
        force_n=40.0,
        mounted=Mounted("robotiq_2f85_mj_description", "base_mount", flange, pos, quat),
    )
