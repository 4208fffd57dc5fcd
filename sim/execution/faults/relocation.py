"""Objects that are disturbed from outside: which may be, and putting one down where it fits."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

import mujoco
import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from sim.errors import SimulationError
from sim.execution.faults.fault import Fault, Injection, unknown
from sim.geometry.mjcf import solid_geoms, yaw_quat
from sim.perception.sensors import ObjectPose
from sim.simulation.plant import CONTACT_FLICKER_S
from sim.simulation.workcell import Workcell
from sim.skills.placing import is_carried
from sim.world.places import Slot
from sim.world.shapes import about_z

BETWEEN_FINGERS_M = 0.0275
"""An object nearer than this to the point between the pads counts as between the fingers."""

MAX_SLOT_OFFSET = np.array([0.005, 0.005, np.radians(5)])
"""Greatest offset along x, along y and about z of an object that is moved into a slot: m, m and rad."""


class ObjectFault(Fault):
    """A fault that happens to an object, unless the hand holds it."""

    noun = "OBJECT"
    refusal = "the hand holds it"

    @classmethod
    def candidates(cls, model: ManipulationModel, rng: np.random.Generator) -> Sequence[str]:
        """Return the names of all movable objects; see `Fault.candidates`."""
        if movable := [obj.name for obj in model.objects if not obj.fixed]:
            return movable
        raise SimulationError("every object is fixed")

    def objection(self, model: ManipulationModel) -> str | None:
        """See `Fault.objection`."""
        return unknown(self.argument, [obj.name for obj in model.objects], "object")

    def inject(self, injection: Injection) -> dict[str, str] | None:
        """See `Fault.inject`."""
        free = not is_in_hand(injection.cell, self.argument)
        return {"object": self.argument} if free and self.disturb(injection) else None

    @abstractmethod
    def disturb(self, injection: Injection) -> bool:
        """Disturb the object, which the hand does not hold; return False if that is not possible now."""


def is_in_hand(cell: Workcell, obj: str) -> bool:
    """Return whether an object is in the hand or between its open fingers, where it cannot be moved."""
    contacts, data = cell.contacts, cell.data
    if contacts.handled == obj and data.time - contacts.pressed < CONTACT_FLICKER_S:
        return True
    tool, body = data.site(cell.scene.robot.tool).xpos, data.body(obj)
    beside = body.xmat.reshape(3, 3).T @ (tool - body.xpos)
    return cell.scene.shapes[obj].distance(beside) < BETWEEN_FINGERS_M


def in_slot(cell: Workcell, rng: np.random.Generator, obj: str, slot: Slot) -> tuple[np.ndarray, float]:
    """Return a (3,) position, m, and a yaw, rad, of an object in a slot, at a random offset from its centre."""
    off = rng.uniform(-1, 1, 3) * MAX_SLOT_OFFSET
    height = float(cell.scene.shapes[obj].half[2]) + 0.001
    return slot.position + [off[0], off[1], height], float(slot.yaw + off[2])


def put(cell: Workcell, obj: str, position: np.ndarray, yaw: float) -> bool:
    """Put an object upright at a (3,) position, m, with a yaw, rad, at rest; return False if it does not fit there.

    It fits if it is supported from below, and without contact just above the support.
    """
    if not is_carried(cell, obj, ObjectPose(cell.scene.shapes[obj], position, about_z(yaw))):
        return False
    now, model = cell.data, cell.scene.mujoco
    scratch = mujoco.MjData(model)
    scratch.qpos[:] = now.qpos
    pose = scratch.joint(obj).qpos
    pose[:3], pose[3:] = position, yaw_quat(yaw)
    mujoco.mj_kinematics(model, scratch)
    mujoco.mj_collision(model, scratch)
    if np.isin(scratch.contact.geom[: scratch.ncon], solid_geoms(model, obj)).any():
        return False
    now.joint(obj).qpos[:], now.joint(obj).qvel[:] = pose, 0.0
    return True
