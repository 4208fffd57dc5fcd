"""Slip: the held object slips from the hand."""

import math

import numpy as np

from sim.execution.faults.fault import Fault, Injection

LIFTED_HEIGHT_M = 0.01
"""An object counts as lifted when it is this much higher than where it was gripped."""

SLIP_DURATION_S = 0.25
"""How long the hand is open when an object slips from it."""

SLIP_GAP_M = 0.02
"""By how much the hand opens then."""


class Slip(Fault):
    """The hand opens for a moment, a random time after the object hangs in it."""

    kind = "slip"
    refusal = "nothing hangs in the hand"
    grasps = True

    def inject(self, injection: Injection) -> dict[str, str] | None:
        """See `Fault.inject`."""
        cell, now = injection.cell, float(injection.cell.data.time)
        obj = cell.contacts.handled
        if obj is None or cell.lost_contact:
            injection.since = injection.height = math.inf
            return None
        height = float(cell.data.body(obj).xpos[2])
        if math.isinf(injection.height):
            injection.height = height
        # Nothing slips while it is lowered: it may already touch what carries it.
        if not cell.attached and height - injection.height < LIFTED_HEIGHT_M:
            return None
        injection.since = min(injection.since, now)
        if now - injection.since < injection.delay:
            return None
        hold, gripper, until = cell.gripper, cell.scene.robot.gripper, now + SLIP_DURATION_S
        least = gripper.opened(np.array([cell.data.joint(finger).qpos[0] for finger in gripper.joints])) + SLIP_GAP_M
        cell.gripper = lambda width: hold(max(width, least) if cell.data.time < until else width)
        return {"object": obj}
