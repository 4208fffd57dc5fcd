"""Slip: the held object slips from the hand."""

from __future__ import annotations

import numpy as np

from sim.execution.faults.fault import Fault, Injection
from sim.geometry.mjcf import solid_geoms
from sim.simulation.plant import CONTACT_FLICKER_S
from sim.simulation.workcell import Workcell

SLIP_DURATION_S = 0.25
"""How long the hand is open when an object slips from it."""

SLIP_GAP_M = 0.02
"""By how much the hand opens then."""


class Slip(Fault):
    """The hand opens for a moment, a random time after an object hangs in it."""

    kind = "slip"
    refusal = "nothing hangs in the hand"
    needs_grasps = True

    def inject(self, injection: Injection) -> dict[str, str] | None:
        """See `Fault.inject`."""
        cell, hold, now = injection.cell, injection.cell.gripper, float(injection.cell.data.time)
        if not _hangs(cell):
            injection.possible_since = None
            return None
        if injection.possible_since is None:
            injection.possible_since = now
        if now - injection.possible_since < injection.delay:
            return None
        gripper, until = cell.scene.robot.gripper, now + SLIP_DURATION_S
        least = gripper.opened(np.array([cell.data.joint(finger).qpos[0] for finger in gripper.joints])) + SLIP_GAP_M
        cell.gripper = lambda width: hold(max(width, least) if cell.data.time < until else width)
        return {"object": str(cell.contacts.handled)}


def _hangs(cell: Workcell) -> bool:
    """Return whether the pads press an object that touches nothing else."""
    obj, model = cell.contacts.handled, cell.scene.mujoco
    if obj is None or cell.data.time - cell.contacts.pressed > CONTACT_FLICKER_S:
        return False
    pairs, is_robot = cell.data.contact.geom, cell.scene.robot.bodies(model)[model.geom_bodyid]
    return not (np.isin(pairs, solid_geoms(model, obj)).any(axis=1) & ~is_robot[pairs].any(axis=1)).any()
