"""Where an object can be put down: free slots, its supports there, and obstacles."""

from collections.abc import Callable

import mujoco
import numpy as np

from sim.geometry.mjcf import first_met, solid_geoms
from sim.geometry.rectangle import Rectangle, overlap, overlap_depth
from sim.perception.grounding import middle_of_supports, resting
from sim.perception.sensors import ObjectPose, Poses
from sim.simulation.workcell import Workcell
from sim.skills.skill import NoSpaceError, SkillError
from sim.world.places import OBJECT_GAP_M, Slot
from sim.world.shapes import ObjectShape

MAX_OVERHANG_M = 0.005
"""Greatest distance of an object from the middle of its supports, towards the centre of its slot, m."""

MAX_UNEVENNESS_M = 0.005
"""Greatest difference in height between objects that together support another one."""

SUPPORT_TOLERANCE_M = 0.005
"""Greatest gap or overlap, in height, between the underside of an object and the surface right below it, m."""

OVER_SUPPORT_M = 0.003
"""By how much an object is raised in a collision check with fixtures, m, so that its support does not count."""

DISTANCE_CAP_M = 0.1
"""Distance from other objects' centres beyond which slots are equally good."""


def free_slot(cell: Workcell, obj: str, location: str) -> Slot:
    """Return a location's slot into which an object fits; of several, the farthest from other objects on its level.

    Raises:
        NoSpaceError: the object fits into none.
        SkillError: it would not rest on all its supports there.
    """

    def preference(slot: Slot) -> tuple[bool, float]:
        _, lacking, distance = _clearance(cell, obj, slot)
        return not lacking, distance

    slot = max(cell.scene.slots[location], key=preference)
    check_free(cell, obj, slot)
    return slot


def check_free(cell: Workcell, obj: str, slot: Slot) -> None:
    """Raise NoSpaceError unless an object fits into a slot, SkillError unless it would rest on all its supports."""
    other, lacking, _ = _clearance(cell, obj, slot)
    if lacking:
        missing = np.ceil(1000 * lacking) / 10
        words = f"no room for {obj} on {slot.location}: {other} is {missing:.1f} cm too close"
        raise NoSpaceError(words, [other], at_goal=True)
    poses, under = _supports(cell, obj, slot)
    place = Rectangle(resting_centre(cell, obj, slot)[:2], cell.scene.shapes[obj].half[:2], slot.yaw)
    tops = {other: poses[other].top for other in under.values()}
    for other, top in tops.items():
        if not overlap(place, poses[other].footprint) or top < max(tops.values()) - MAX_UNEVENNESS_M:
            raise SkillError(f"{obj} would not rest on {other}")


def obstacles(cell: Workcell, obj: str) -> Callable[[ObjectPose], bool]:
    """Return a test whether an object in a pose overlaps another one, seen from above, or collides with a fixture."""
    model, data = cell.scene.mujoco, mujoco.MjData(cell.scene.mujoco)
    data.qpos[:] = cell.data.qpos
    poses = {other: cell.observe(other) for other in cell.shapes if other != obj}
    taken = [other.footprint for other in poses.values()]
    own = solid_geoms(model, obj)
    moving = (
        np.isin(model.geom_bodyid, [model.body(other).id for other in poses])
        | cell.scene.robot.bodies(model)[model.geom_bodyid]
    )

    def meets(pose: ObjectPose) -> bool:
        if any(overlap(pose.footprint, other) for other in taken):
            return True
        data.joint(obj).qpos[:3] = pose.position + [0.0, 0.0, OVER_SUPPORT_M]
        mujoco.mju_mat2Quat(data.joint(obj).qpos[3:], pose.rotation.ravel())
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        pairs = data.contact.geom[: data.ncon]
        return bool((np.isin(pairs, own).any(axis=1) & ~moving[pairs].any(axis=1)).any())

    return meets


def is_carried(cell: Workcell, obj: str, pose: ObjectPose) -> bool:
    """Return whether an object in a pose has a support right below the corners and the middle of its footprint."""
    model, place, down = cell.scene.mujoco, pose.footprint, np.array([0.0, 0.0, -1.0])
    starts = [np.array([*point, pose.position[2]]) for point in (place.centre, *place.corners)]
    drops = [first_met(model, cell.data, start, down, without=model.body(obj).id)[1] for start in starts]
    return all(abs(drop - pose.below) <= SUPPORT_TOLERANCE_M for drop in drops)


def resting_centre(cell: Workcell, obj: str, slot: Slot) -> np.ndarray:
    """Return the (3,) centre that an object would have in a slot, m, on the objects that support the slot now."""
    scene, supports = cell.scene, cell.scene.model.location(slot.location).on
    if not supports:
        return slot.position + [0.0, 0.0, scene.shapes[obj].half[2]]
    poses, under = _supports(cell, obj, slot)
    floor = max(poses[other].top for other in under.values())
    middle = middle_of_supports(scene, poses, under, supports)
    off = slot.position[:2] - middle
    off *= min(1.0, MAX_OVERHANG_M / max(float(np.hypot(*off)), 1e-9))
    return np.array([*middle + off, floor + scene.shapes[obj].half[2]])


def _supports(cell: Workcell, obj: str, slot: Slot) -> tuple[Poses, dict[str, str]]:
    """Return the poses of the other objects, and which of them rests at each location that supports a slot."""
    poses = {other: cell.observe(other) for other in cell.shapes if other != obj}
    supports = cell.scene.model.location(slot.location).on
    under = {at.location: other for other, at in resting(cell.scene, poses).items()} if supports else {}
    for place in supports:
        if place not in under:
            raise SkillError(f"{obj} would not rest on {place}: nothing stands there")
    return poses, {place: under[place] for place in supports}


def _clearance(cell: Workcell, obj: str, slot: Slot) -> tuple[str, float, float]:
    """Return how an object fits into a slot beside the other objects on its level, except those that carry it.

    The results are the object most in its way, by how much that one is too close, m (0 if there is room), and the
    distance between centres to the nearest other object, m, at most `DISTANCE_CAP_M`.
    """
    shapes = cell.shapes
    centre = resting_centre(cell, obj, slot)
    poses, under = _supports(cell, obj, slot)
    poses = {other: pose for other, pose in poses.items() if other not in under.values()}
    lacking = {other: lacking_room(shapes[obj], centre, slot.yaw, pose) for other, pose in poses.items()}
    level = {other: missing for other, missing in lacking.items() if missing is not None}
    most = max(level, key=level.__getitem__, default="")
    distances = [float(np.hypot(*(poses[other].position - centre)[:2])) for other in level]
    return most, level.get(most, 0.0), min([*distances, DISTANCE_CAP_M])


def lacking_room(shape: ObjectShape, centre: np.ndarray, yaw: float, other: ObjectPose) -> float | None:
    """Return by how much another object is too close, m, for one to stand at a (3,) centre, m, with a yaw, rad.

    Return 0 if there is room, None if the other object is on another level.
    """
    low, high = centre[2] - shape.half[2] + OBJECT_GAP_M, centre[2] + shape.half[2] - OBJECT_GAP_M
    if other.top <= low or other.underside[2] >= high:
        return None
    return overlap_depth(Rectangle(centre[:2], shape.half[:2] + OBJECT_GAP_M, yaw), _covered(other, yaw))


def _covered(pose: ObjectPose, heading: float) -> Rectangle:
    """Return the footprint of an object; if it stands, at the equivalent yaw that is nearest to a heading, rad."""
    if not pose.is_upright:
        return pose.footprint
    return Rectangle(pose.position[:2], pose.shape.half[:2], pose.shape.yaw_near(pose.yaw, heading))
