"""Slip: the held object slips from the hand."""

import math

import numpy as np

from sim.execution.faults.fault import Fault, Injection

LIFTED_HEIGHT_M = 0.01
"""Height above where it was gripped at which an object counts as lifted, m."""

SLIP_DURATION_S = 0.25
"""Time for which the hand is open when an object slips from it, s."""

SLIP_GAP_M = 0.02
"""Distance by which the hand opens when an object slips from it, m."""


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
        # An object that is being lowered does not slip: it may already touch its support.
        if not cell.attached and height - injection.height < LIFTED_HEIGHT_M:
            return None
        injection.since = min(injection.since, now)
        if now - injection.since < injection.delay:
            return None
        hold, gripper, until = cell.gripper, cell.scene.robot.gripper, now + SLIP_DURATION_S
        least = gripper.opened(np.array([cell.data.joint(finger).qpos[0] for finger in gripper.joints])) + SLIP_GAP_M
        cell.gripper = lambda width: hold(max(width, least) if cell.data.time < until else width)
        return {"object": obj}
