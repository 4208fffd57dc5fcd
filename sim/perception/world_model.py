"""Regrounding: a model and a scene that fit what is seen, wherever objects have come to lie.

What lies off every location gets a temporary location of its own, from which it can be taken and to which nothing can
be put. What it keeps the hand from is said by the locations too: nothing goes where it lies in the way, and what it
rests on cannot be taken before it is gone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from prefplan.models.manipulation.model import Location, ManipulationModel, ManipulationState, Object
from sim.geometry.rectangle import Rectangle, overlap
from sim.perception.grounding import NOWHERE, carriers, footprint, hand_over, resting
from sim.perception.sensors import Poses, on_table
from sim.world.places import FINGER_DEPTH, FINGER_HALF, Slot
from sim.world.scene import Scene
from sim.world.shapes import extent

ROOM = 0.006
"""Least gap between an object that is put down and one that lies beside its slot, m."""


@dataclass(frozen=True)
class Regrounded:
    """The world as it is seen.

    Attributes:
        scene: the scene with its model, to which locations and objects may have been added, and which begins here;
            what fell from the table is no longer in it.
        state: where everything is.
        lost: objects that the arm cannot get at.
    """

    scene: Scene
    state: ManipulationState
    lost: tuple[str, ...] = ()


def reground(
    scene: Scene,
    data: mujoco.MjData,
    poses: Poses,
    *,
    hand: str,
    held: str | None,
    marks: frozenset[tuple[str, str]],
    reachable: Callable[[np.ndarray], bool],
) -> Regrounded:
    """Return a scene and a state that agree with what is seen.

    Args:
        scene: as it was built from the scenario.
        data: its state, of which the robot knows its own part.
        poses: where every object is seen, also those that the model does not have.
        hand: where the hand was last sent.
        held: what it holds.
        marks: what the past left behind and no sensor shows.
        reachable: whether the hand gets at a position.
    """
    model = scene.model
    known = {thing.name for thing in model.objects}
    gone = [name for name, pose in poses.items() if not on_table(pose)]
    seen = {name: pose for name, pose in poses.items() if name != held and name not in gone}
    rests = resting(scene, seen)
    names = _temporary_names(model, [thing for thing in seen if thing not in rests])
    where = {thing: slot.location for thing, slot in rests.items()} | names
    lost = tuple(thing for thing in seen if thing in names and not reachable(seen[thing].position))
    temporary = [
        _temporary_location(scene, seen, thing, name, [where[below] for below in carriers(scene, seen, thing)])
        for thing, name in names.items()
    ]
    slots = {
        name: (Slot(name, 0, seen[thing].position - [0.0, 0.0, scene.shapes[thing].half[2]], seen[thing].yaw),)
        for thing, name in names.items()
    }
    over = _hand(replace(scene, slots=scene.slots | slots), data, (hand, *names.values(), *scene.slots))
    if over != NOWHERE or hand != model.start or hand in scene.slots:
        hand = over
    state = ManipulationState(
        hand,
        held,
        tuple((thing, where[thing]) for thing in seen),
        marks,
        slots=tuple((thing, slot.index) for thing, slot in rests.items() if model.slot_counts[slot.location] > 1),
    )
    objects = [thing for thing in model.objects if thing.name not in gone]
    objects += [Object(name, where.get(name, model.locations[0].name)) for name in poses if name not in {*known, *gone}]
    locations = [_obstructed(scene, seen, place, rests, names, lost) for place in model.locations]
    model = replace(
        model,
        locations=(*locations, *temporary),
        objects=tuple(replace(thing, fixed=thing.fixed or thing.name in lost) for thing in objects),
        begin=state,
    )
    scene = replace(scene, model=model, slots=scene.slots | slots, temporary=frozenset(slots))
    return Regrounded(scene, state, (*lost, *gone))


def _hand(scene: Scene, data: mujoco.MjData, candidates: tuple[str, ...]) -> str:
    """Return the first of some locations that the hand is over."""
    over = (name for name in candidates if name in scene.slots and hand_over(scene, data, name))
    return next(over, NOWHERE)


def _temporary_names(model: ManipulationModel, things: list[str]) -> dict[str, str]:
    """Return a name for the place of each of some objects, such that it gives no proposition of the model."""
    taken = [place.name for place in model.locations] + [thing.name for thing in model.objects] + things
    stem = "spot"
    while any(stem in name for name in (*taken, *model.marks, *model.propositions)):
        stem += "_"
    return {thing: f"{stem}{i + 1}" for i, thing in enumerate(things)}


def _temporary_location(scene: Scene, poses: Poses, thing: str, name: str, below: list[str]) -> Location:
    """Return where an object happens to lie: on the locations of others, or somewhere on the table."""
    x, y = map(float, poses[thing].position[:2])
    on = tuple(dict.fromkeys(below))
    return Location(name, at=None if on else (x, y), on=on, closed=True)


def _obstructed(
    scene: Scene, poses: Poses, place: Location, rests: dict[str, Slot], names: dict[str, str], lost: tuple[str, ...]
) -> Location:
    """Return a location with what keeps objects from being put there.

    Where something lies in the way nothing is put before it is gone, which it never is where the arm cannot get at it.
    """
    own = [thing for thing, slot in rests.items() if slot.location == place.name]
    free = [slot for slot in scene.slots[place.name] if all(_has_room(scene, poses, slot, thing) for thing in own)]
    blocking = [
        thing for thing in names if any(not _has_room(scene, poses, slot, thing) for slot in scene.slots[place.name])
    ]
    clear_of = [names[thing] for thing in blocking]
    if len(free) < place.capacity - len(own):
        clear_of.append(place.name)
    closed = place.closed or any(thing in lost for thing in blocking)
    return replace(place, closed=closed, clear_of=(*place.clear_of, *clear_of))


def _has_room(scene: Scene, poses: Poses, slot: Slot, thing: str) -> bool:
    """Return whether something can be put into a slot beside an object, by open fingers along one of two lines."""
    size = extent(scene.shapes.values())
    half, pose = scene.shapes[thing].half, poses[thing]
    bottom = pose.position[2] - half[2]
    if bottom > slot.position[2] + size.high or pose.position[2] + half[2] < slot.position[2] + ROOM:
        return True
    other = footprint(scene, poses, thing)
    block = Rectangle(slot.position[:2], size.half + ROOM, slot.yaw)
    if overlap(block, other):
        return False
    fingers = np.array([size.opening / 2 + FINGER_DEPTH, FINGER_HALF])
    lines = (slot.yaw, slot.yaw + np.pi / 2)
    return any(not overlap(Rectangle(slot.position[:2], fingers, line), other) for line in lines)
