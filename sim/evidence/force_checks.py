"""Checks of the forces in a log against the physics of its states: torques of the arm, forces on the pads."""

from __future__ import annotations

import numpy as np

from prefplan.claims import Check
from sim.evidence.dynamics import Dynamics
from sim.evidence.log import Log
from sim.evidence.replay import RecordedWorld

TORQUE_TOLERANCE = 0.3
"""Greatest difference of a torque from the derived one, as a share of its limit; it is 0.17 in genuine logs."""

RUN_TOLERANCE = {"commands": 0.35, "motion": 0.6}
"""Greatest RMS difference over a run, as a share of the joint's RMS torque; it is 0.15 and 0.31 in genuine logs."""

LEAST_TORQUE = 0.01
"""RMS differences below this share of a joint's limit do not count: the torque of an idle joint is no larger."""

SCALE_TOLERANCE = 0.03
"""Greatest difference from 1 of the factor between recorded and derived torques of the most loaded joint; it is 0.004
in genuine logs."""

PAD_TOLERANCE_N, PAD_TOLERANCE = 5.0, 0.2
"""Greatest difference of a pad's force from the derived one, N and as a share; it is 2.6 N in genuine logs."""

IMPACT_TOLERANCE = 1.0
"""Greatest excess of a pad's force for a single frame, as a share: an impact lasts a step or two, and velocities are
recorded at its end."""


def check_torques(log: Log, world: RecordedWorld, dynamics: Dynamics) -> Check:
    """Check the recorded torques against the arm's commands, and the commands against its motion."""
    name, robot, limits = "torques", world.robot, world.robot.torque_limits
    if len(log.times) < 2:
        return Check(name, True, "the arm did not move")
    greatest, midway = dynamics.torques
    pairs = {"commands": (log.torques[1:], greatest[1:]), "motion": (midway, dynamics.needed)}
    worst = 0.0
    for source, (found, derived) in pairs.items():
        off = np.abs(found - derived) / limits
        overall = np.sqrt(np.mean(off**2, axis=0))
        bound = RUN_TOLERANCE[source] * np.sqrt(np.mean((derived / limits) ** 2, axis=0)) + LEAST_TORQUE
        frame, joint = map(int, np.unravel_index(int(off.argmax()), off.shape))
        if off.max() > TORQUE_TOLERANCE or np.any(overall > bound):
            if off.max() <= TORQUE_TOLERANCE:
                joint = int((overall / bound).argmax())
                frame = int(off[:, joint].argmax())
            words = (
                f"{robot.joints[joint]} gives {found[frame, joint]:.1f} N m at {log.times[frame + 1]:.2f} s, but its"
            )
            return Check(name, False, f"{words} {source} imply {derived[frame, joint]:.1f} N m")
        worst = max(worst, float(off.max()))
    joint = int(np.argmax(np.mean(greatest, axis=0)))
    factor = float(log.torques[1:, joint] @ greatest[1:, joint] / (greatest[1:, joint] @ greatest[1:, joint]))
    if abs(factor - 1) > SCALE_TOLERANCE:
        return Check(name, False, f"{robot.joints[joint]} gives {factor:.1%} of the torques that its commands imply")
    return Check(name, True, f"as commands and motion imply, within {worst:.0%} of the limits")


def check_grip(log: Log, dynamics: Dynamics) -> Check:
    """Check the forces on the pads against the contacts that follow from positions, velocities and commands.

    MuJoCo sometimes misses a contact for a single step, so a force is too small only if that of the next frame is, too.
    A held object that hits the table is pressed against the pads for a step or two, so a force is too large only if
    that of the next frame is, too, or if it is too large even for an impact.
    """
    name, forces = "pad forces", log.pad_forces
    derived = dynamics.pad_forces
    at_once = forces - derived * (1 + IMPACT_TOLERANCE) - PAD_TOLERANCE_N
    over = forces - derived * (1 + PAD_TOLERANCE) - PAD_TOLERANCE_N
    under = derived * (1 - PAD_TOLERANCE) - PAD_TOLERANCE_N - forces
    lasting = (np.minimum(found, np.vstack([found[1:], found[-1:]])) for found in (over, under))
    off = np.maximum.reduce([at_once, *lasting])
    frame, pad = np.unravel_index(int(off.argmax()), off.shape)
    if off[frame, pad] > 0:
        words = f"{forces[frame, pad]:.1f} N on a pad at {log.times[frame]:.2f} s, but commands and contacts give"
        return Check(name, False, f"{words} {derived[frame, pad]:.1f} N")
    return Check(name, True, f"as contacts and commands give; at most {forces.max():.1f} N")
