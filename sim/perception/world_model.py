"""World model: a planning model and a scene that agree with an observation.

An object off every location gets a temporary location of its own: it can be grasped there, upright or not, and
nothing can be put there. It also obstructs others: nothing is released at a location that it overlaps, and an
object below it cannot be grasped first.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import mujoco
import numpy as np

from prefplan.models.manipulation.model import Location, ManipulationState, Object
from sim.geometry.rectangle import Rectangle, overlap
from sim.perception.grounding import NOWHERE, carriers, hand_location, present_marks, resting
from sim.perception.sensors import ObjectPose, Poses, on_table
from sim.world.places import Slot, extent, unused_names
from sim.world.scene import Scene

STRAY_GAP_M = 0.006
"""Least gap between an object that is put down and an object beside its slot, m."""


def reground(
    scene: Scene,
    data: mujoco.MjData,
    poses: Poses,
    *,
    hand: str,
    held: str | None,
    marks: frozenset[tuple[str, str]],
    lost_because: Callable[[str], str | None],
) -> tuple[Scene, dict[str, str]]:
    """Return a scene whose model starts in the observed state, and by object the reason why the arm cannot grasp it.

    The model may have additional locations and objects, and lacks the objects that fell from the table. `scene` is the
    one built from the scenario; `lost_because` returns why the hand cannot grasp an object, or None. The other
    arguments are those of `observe`.
    """
    model = scene.model
    known = [obj.name for obj in model.objects]
    # Objects that fell earlier are no longer observed.
    gone = [name for name in dict.fromkeys([*known, *poses]) if not on_table(poses.get(name))]
    seen = {name: pose for name, pose in poses.items() if name != held and name not in gone}
    rests = resting(scene, seen)
    loose = [obj for obj in seen if obj not in rests]
    names = dict(zip(loose, unused_names(model, "spot", len(loose), taken=loose), strict=True))
    where = {obj: slot.location for obj, slot in rests.items()} | names
    lost = dict.fromkeys(gone, "fell from the table")
    lost |= {obj: why for obj in names if (why := lost_because(obj)) is not None}
    temporary = []
    for obj, name in names.items():
        on = tuple(dict.fromkeys(where[below] for below in carriers(seen, obj)))
        x, y = map(float, seen[obj].position[:2])
        temporary.append(Location(name, at=None if on else (x, y), on=on, closed=True))
    slots = {name: (Slot(name, 0, seen[obj].underside, seen[obj].yaw),) for obj, name in names.items()}
    over = hand_location(replace(scene, slots=scene.slots | slots), data, (hand, *names.values(), *scene.slots))
    if over != NOWHERE or hand != model.start or hand in scene.slots:
        hand = over
    state = ManipulationState(
        hand,
        held,
        tuple((obj, where[obj]) for obj in seen),
        present_marks(marks, poses),
        slots=tuple((obj, slot.index) for obj, slot in rests.items() if model.slot_counts[slot.location] > 1),
    )
    objects = [obj for obj in model.objects if obj.name not in gone]
    objects += [Object(name, where.get(name, model.locations[0].name)) for name in poses if name not in {*known, *gone}]
    locations = [_obstructed(scene, seen, place, rests, names, lost) for place in model.locations]
    model = replace(
        model,
        locations=(*locations, *temporary),
        objects=tuple(replace(obj, fixed=obj.fixed or obj.name in lost) for obj in objects),
        begin=state,
    )
    return replace(scene, model=model, slots=scene.slots | slots, temporary=frozenset(slots)), lost


def spots_in(actions: Sequence[str], scene: Scene, state: ManipulationState) -> dict[str, dict[str, object]]:
    """Return the temporary locations in some actions, each with its `object` and its position `at`: (x, y), m."""
    named = {scene.model.action(action).location for action in actions} & scene.temporary
    return {
        place: {"object": obj, "at": [round(float(x), 3) for x in scene.slots[place][0].position[:2]]}
        for obj, place in state.places
        if place in named
    }


def _obstructed(
    scene: Scene,
    poses: Poses,
    place: Location,
    rests: Mapping[str, Slot],
    names: Mapping[str, str],
    lost: Mapping[str, str],
) -> Location:
    """Return a location with those to empty before a release there, `clear_of`; closed if one cannot be emptied."""
    own = [obj for obj, slot in rests.items() if slot.location == place.name]
    free = [slot for slot in scene.slots[place.name] if all(_is_free_beside(scene, slot, poses[obj]) for obj in own)]
    blocking = [
        obj for obj in names if any(not _is_free_beside(scene, slot, poses[obj]) for slot in scene.slots[place.name])
    ]
    clear_of = [names[obj] for obj in blocking]
    if len(free) < place.capacity - len(own):
        clear_of.append(place.name)
    closed = place.closed or any(obj in lost for obj in blocking)
    return replace(place, closed=closed, clear_of=(*place.clear_of, *clear_of))


def _is_free_beside(scene: Scene, slot: Slot, pose: ObjectPose) -> bool:
    """Return whether an object can be released in a slot beside another at a pose, in one of two closing directions."""
    size, other = extent(scene.shapes.values()), pose.footprint
    if pose.underside[2] > slot.position[2] + size.high or pose.top < slot.position[2] + STRAY_GAP_M:
        return True
    block = Rectangle(slot.position[:2], size.half + STRAY_GAP_M, slot.yaw)
    if overlap(block, other):
        return False
    gripper = scene.robot.gripper
    fingers = np.array([size.opening / 2 + gripper.finger_depth_m, gripper.finger_half_width_m])
    headings = (slot.yaw, slot.yaw + np.pi / 2)
    return any(not overlap(Rectangle(slot.position[:2], fingers, heading), other) for heading in headings)
