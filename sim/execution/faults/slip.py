"""Slip: the held object slips from the hand."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from sim.execution.faults.fault import Fault, Injection, never_grasps
from sim.simulation.plant import CONTACT_FLICKER_S
from sim.simulation.workcell import Workcell

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

    def unavailable_because(self, model: ManipulationModel) -> str | None:
        """See `Fault.unavailable_because`."""
        return never_grasps(model)

    def attempts(self, injection: Injection) -> Iterator[dict[str, str] | None]:
        """See `Fault.attempts`."""
        for hanging in _hanging_times(injection.cell):
            yield None if hanging is None or hanging < injection.delay else self.inject(injection)

    def inject(self, injection: Injection) -> dict[str, str]:
        """See `Fault.inject`."""
        cell, hold = injection.cell, injection.cell.gripper
        gripper, until = cell.scene.robot.gripper, float(cell.data.time) + SLIP_DURATION_S
        least = gripper.opened(np.array([cell.data.joint(finger).qpos[0] for finger in gripper.joints])) + SLIP_GAP_M
        cell.gripper = lambda width: hold(max(width, least) if cell.data.time < until else width)
        return {"object": str(cell.contacts.handled)}


def _hanging_times(cell: Workcell) -> Iterator[float | None]:
    """Yield in each control period for how long an object has hung in the hand, s; None if nothing does."""
    gripped: tuple[str, float] | None = None
    since: float | None = None
    while True:
        now, obj = float(cell.data.time), cell.contacts.handled
        hanging = None
        if obj is None or now - cell.contacts.pressed > CONTACT_FLICKER_S:
            gripped = since = None
        else:
            height = float(cell.data.body(obj).xpos[2])
            if gripped is None or gripped[0] != obj:
                gripped = obj, height
            # Nothing slips while it is lowered: it may already touch what carries it.
            if cell.attached or height - gripped[1] >= LIFTED_HEIGHT_M:
                since = now if since is None else since
                hanging = now - since
        yield hanging
