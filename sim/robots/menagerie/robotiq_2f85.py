"""The Robotiq 2F-85, which is mounted on arms without a hand of their own."""

from __future__ import annotations

from sim.robots.menagerie.arm import HAND, MenagerieHand, Mounted


def robotiq_2f85(
    flange: str, pos: tuple[float, float, float], quat: tuple[float, float, float, float]
) -> MenagerieHand:
    """Return the hand on a body of an arm, its frame there at a position, m, with an orientation."""
    return MenagerieHand(
        # The middle of the closing pads.
        tool=f"{HAND}base",
        tool_m=0.150,
        actuator=f"{HAND}fingers_actuator",
        # Robotiq's data sheet: stroke, and a force of 20 to 235 N to choose from.
        opening_m=0.085,
        force_n=40.0,
        mounted=Mounted("robotiq_2f85_mj_description", "base_mount", flange, pos, quat),
    )
