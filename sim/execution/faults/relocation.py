"""Faults that disturb an object from outside: which objects these may be, free slots, and putting an object down."""

from abc import abstractmethod
from collections.abc import Sequence

import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from sim.errors import SimulationError
from sim.execution.faults.fault import Fault, Injection, unknown
from sim.geometry.mjcf import yaw_quat
from sim.geometry.rectangle import Rectangle, overlap
from sim.perception.sensors import object_pose, stored
from sim.simulation.plant import CONTACT_FLICKER_S
from sim.simulation.workcell import Workcell
from sim.world.places import Slot

BETWEEN_FINGERS_M = 0.0275
"""An object nearer than this to the point between the pads counts as between the fingers, m."""

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


def is_free(cell: Workcell, slot: Slot) -> bool:
    """Return whether any object could be placed in a slot without contact; False at closed locations and on objects."""
    scene, data = cell.scene, cell.data
    if scene.model.location(slot.location).on or scene.model.location(slot.location).closed:
        return False
    half = max(float(scene.shapes[obj].half[:2].max()) for obj in scene.shapes)
    place = Rectangle(slot.position[:2], np.full(2, half + MAX_SLOT_OFFSET[0]), slot.yaw)
    poses = [object_pose(scene, data, obj) for obj in scene.shapes if not stored(scene, data, obj)]
    return not any(overlap(place, pose.footprint) for pose in poses)


def put_into(cell: Workcell, rng: np.random.Generator, obj: str, slot: Slot) -> None:
    """Put an object into a slot, at a random offset from its centre."""
    off = rng.uniform(-1, 1, 3) * MAX_SLOT_OFFSET
    height = float(cell.scene.shapes[obj].half[2]) + 0.001
    put(cell, obj, slot.position + [off[0], off[1], height], slot.yaw + off[2])


def put(cell: Workcell, obj: str, position: np.ndarray, yaw: float) -> None:
    """Put an object upright at a (3,) position, m, with a yaw, rad, at rest."""
    joint = cell.data.joint(obj)
    joint.qpos[:3], joint.qpos[3:], joint.qvel[:] = position, yaw_quat(yaw), 0.0
