"""Skills: how each symbolic action, `transit grasp transport release`, is carried out by motion and touch."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from prefplan.models.manipulation.action_costs import ACTION_KINDS
from sim.errors import BlockedError, SimulationError
from sim.geometry.rectangle import Rectangle, overlap
from sim.motion.kinematics import CONTROL_PERIOD, wrap
from sim.perception.grounding import AT_RADIUS, hand_over
from sim.simulation.workcell import Workcell
from sim.skills.transfer import travel
from sim.world.places import FINGER_TIPS, Slot
from sim.world.shapes import Grip, extent

HOVER = 0.12
"""Height of the tool over a slot's centre before and after it works there, m: a held block clears one resting."""

CLEARANCE = 0.03
"""Least height at which the tool or what it holds passes over resting objects, m."""

SQUEEZE = 0.015
"""How much narrower than the object the hand is commanded to close, m: about 15 N on either side."""

FIRM = 5.0
"""Force on each pad from which a grip counts as firm, N: a third of what is commanded."""

CLOSING = 4
"""So many widths are looked at while the hand closes: a finger, 11 mm thick, cannot pass through a wall unseen."""

ASTRAY = 0.0015
"""Distance that the fingers keep from everything else, m: the arm comes to rest within 1 mm of where it is sent."""

CLOSE_TIME, OPEN_TIME = 0.35, 0.25
"""Duration of closing and of opening the hand, s."""

STEADY_TIME, GRIP_PATIENCE = 0.1, 0.6
"""How long a grip must stay firm, and how long to wait for that, s."""

SETTLE_TIME = 0.1
"""Wait before measuring an object in the hand and after letting it go, s."""

DROP = 0.0005
"""Height from which an object is let go, m: so that it does not press on what it is put on."""

ROOM, FAR = 0.005, 0.1
"""Least gap between objects that rest side by side, and the distance of their centres that is as good as any, m."""

RESTLESS = 0.008
"""An object seen to be farther from where it was measured moves, m; noise of 1 mm never looks like that."""

TOPPLED = np.radians(45)
"""An object tilted by more than this fell over, rad: the hand takes it only as it stood."""

GLOW_TIME = 1.5
"""How long a marking location works on what was released there, s."""


class SkillError(SimulationError):
    """A skill that ended without its effect; the message says why."""


def perform(cell: Workcell, action: str) -> None:
    """Carry out one symbolic action, e.g. `transport blue san`.

    Raises:
        SkillError: it did not work out; the arm rests and the simulation can go on.
        BlockedError: something is in the way; the same holds.
        SimulationError: the arm cannot get there.
    """
    kind, *arguments = action.split()
    SKILLS[kind](cell, *arguments)


def transit(cell: Workcell, location: str) -> None:
    """Bring the empty hand over a location and whatever is piled up there."""
    cell.watch.handle(None)
    slots = cell.scene.slots[location]
    centre = np.mean([slot.position for slot in slots], axis=0)
    middle = extent(cell.scene.shapes.values()).high / 2
    height = max(centre[2] + middle + HOVER, _passage(cell))
    travel(cell, np.array([*centre[:2], height]), slots[0].yaw, height=_passage(cell))


def grasp(cell: Workcell, thing: str) -> None:
    """Lower the hand on the object below it, close until both pads feel it, and raise it."""
    slot, shape = _slot_below(cell, thing), cell.scene.shapes[thing]
    pose = cell.measure(thing)
    if pose.tilt > TOPPLED:
        raise BlockedError(f"{thing} fell over", ())
    cell.watch.handle(thing)
    yaw = shape.yaw_near(pose.yaw, slot.yaw)
    line, grip = _free_line(cell, pose.position, [(yaw + grip.turn, grip) for grip in shape.ways])
    target, above = pose.position + [0.0, 0.0, grip.lift], pose.position + [0.0, 0.0, HOVER]
    if cell.misses:
        cell.misses -= 1
        target = target + [0.0, 0.0, shape.height + ROOM]
    cell.grip(grip.opening, CONTROL_PERIOD)
    yaw = _move(cell, above, [line, line + np.pi])
    if np.linalg.norm(cell.see(thing).position - pose.position) > RESTLESS:
        raise SkillError(f"{thing} does not lie still")
    _move(cell, target, [yaw])
    cell.grip(grip.width - SQUEEZE, CLOSE_TIME)
    forces = _await_grip(cell)
    if forces is None:
        cell.grip(grip.opening, OPEN_TIME)
    _move(cell, above, [yaw])
    if forces is None:
        raise SkillError(f"the fingers closed without a firm grip on {thing}")
    _check_held(cell, thing)
    cell.tell("grasped", object=thing, force=[round(float(force), 2) for force in forces])


def transport(cell: Workcell, thing: str, location: str) -> None:
    """Carry the held object over the location's free slot."""
    _check_held(cell, thing)
    slot = _free_slot(cell, thing, location)
    middle = _middle(cell, thing, slot)
    cell.watch.handle(thing)
    line, _ = _free_line(cell, middle, _putting(cell, thing, slot))
    cell.watch.handle(thing, aloft=True)
    travel(cell, middle + [0.0, 0.0, HOVER], line, height=_passage(cell, thing))
    _check_held(cell, thing)


def release(cell: Workcell, thing: str, location: str) -> None:
    """Measure the object in the hand, lower it into the free slot, let go and raise the hand.

    Above the slot the object's place in the hand is measured and made good, since it drifts while it is carried; and
    whether the slot is still free is looked at once more.
    """
    _check_held(cell, thing)
    slot = _free_slot(cell, thing, location)
    cell.watch.handle(thing, aloft=True)
    cell.wait(SETTLE_TIME)
    position, yaw = _placing(cell, thing, slot)
    above = position + [0.0, 0.0, HOVER]
    _move(cell, above, [yaw])
    _check_room(cell, thing, slot)
    position, yaw = _placing(cell, thing, slot)
    _check_held(cell, thing)
    cell.watch.handle(thing)
    _move(cell, position, [yaw])
    cell.wait(SETTLE_TIME)
    cell.grip(_grip(cell, thing).opening, OPEN_TIME)
    _move(cell, above, [yaw])
    cell.watch.handle(None)
    error = float(np.hypot(*(cell.measure(thing).position - slot.position)[:2]))
    cell.tell("placed", object=thing, location=location, error_mm=round(error * 1000, 2))
    if cell.scene.model.location(location).marks:
        cell.glowing = list(cell.scene.slots).index(location)
        cell.wait(GLOW_TIME)
        cell.glowing = -1


SKILLS: dict[str, Callable[..., None]] = dict(zip(ACTION_KINDS, (transit, grasp, transport, release), strict=True))


def _move(cell: Workcell, position: np.ndarray, yaws: list[float]) -> float:
    """Move the tool to a position nearby, straight up or down; return which of the yaws it took."""
    goal, yaw = cell.arm.reach(position, yaws)
    cell.follow(cell.arm.move(cell.reference, goal, position, yaw))
    return yaw


def _free_line(cell: Workcell, position: np.ndarray, options: list[tuple[float, Grip]]) -> tuple[float, Grip]:
    """Return the first closing line, with its grip, on which the fingers touch nothing but the object as they close.

    Args:
        cell: the running simulation.
        position: (3,) of the object's middle, m.
        options: lines, rad, and grips to try in turn.

    Raises:
        BlockedError: none is free.
    """
    met: set[str] = set()
    for line, grip in options:
        q, _ = cell.arm.reach(position + [0.0, 0.0, grip.lift], [line, line + np.pi])
        widths = np.linspace(grip.opening, grip.width, CLOSING)
        obstacles = {thing for width in widths for thing in cell.foresee(q, width=float(width), clearance=ASTRAY)}
        if not obstacles:
            return line, grip
        met |= obstacles
    raise BlockedError(f"no room for the fingers: they would touch {' and '.join(sorted(met))}", met)


def _grip(cell: Workcell, thing: str) -> Grip:
    """Return how the hand has the held object."""
    turn = cell.arm.tool(cell.reference).yaw - cell.see(thing).yaw
    return min(cell.scene.shapes[thing].grips, key=lambda grip: abs(wrap(turn - grip.turn, np.pi)))


def _putting(cell: Workcell, thing: str, slot: Slot) -> list[tuple[float, Grip]]:
    """Return the closing lines, each with its grip, at which the held object can be put down square to a slot."""
    grip, shape = _grip(cell, thing), cell.scene.shapes[thing]
    if shape.symmetry > np.pi / 2:
        return [(slot.yaw + grip.turn, grip)]
    return [(slot.yaw, grip), (slot.yaw + np.pi / 2, grip)]


def _middle(cell: Workcell, thing: str, slot: Slot) -> np.ndarray:
    """Return where the centre of an object is when it rests in a slot, on what lies there now."""
    scene, floor = cell.scene, float(slot.position[2])
    below = [other.position[:2] for name in scene.model.location(slot.location).on for other in scene.slots[name]]
    tops = [
        cell.see(other).position[2] + shape.half[2]
        for other, shape in cell.shapes.items()
        if other != thing and any(np.hypot(*(cell.see(other).position[:2] - xy)) < AT_RADIUS for xy in below)
    ]
    return np.array([*slot.position[:2], max(tops, default=floor) + scene.shapes[thing].half[2]])


def _passage(cell: Workcell, held: str | None = None) -> float:
    """Return the height at which the tool, and what it holds, passes over everything that rests."""
    shapes = cell.shapes
    tops = [cell.see(thing).position[2] + shape.half[2] for thing, shape in shapes.items() if thing != held]
    below = shapes[held].half[2] if held else FINGER_TIPS
    return max(tops, default=0.0) + below + CLEARANCE


def _slot_below(cell: Workcell, thing: str) -> Slot:
    """Return the slot at the hand's location where the object rests."""
    position = cell.see(thing).position - [0.0, 0.0, cell.scene.shapes[thing].half[2]]
    slots = [slot for row in cell.scene.slots.values() for slot in row]
    slot = min(slots, key=lambda slot: float(np.linalg.norm(position - slot.position)))
    if np.hypot(*(position - slot.position)[:2]) > AT_RADIUS or not hand_over(cell.scene, cell.data, slot.location):
        raise SkillError(f"{thing} is not below the hand")
    return slot


def _check_held(cell: Workcell, thing: str) -> None:
    if cell.held() != thing:
        raise SkillError(f"the pads do not feel {thing} between them")


def _free_slot(cell: Workcell, thing: str, location: str) -> Slot:
    """Return the slot of a location farthest from the other objects on its level."""
    slot = max(cell.scene.slots[location], key=lambda slot: _room(cell, thing, slot))
    _check_room(cell, thing, slot)
    return slot


def _check_room(cell: Workcell, thing: str, slot: Slot) -> None:
    fits, nearest = _room(cell, thing, slot)
    if not fits:
        raise SkillError(f"no room for {thing} on {slot.location}: another object is {nearest * 1000:.0f} mm from it")


def _room(cell: Workcell, thing: str, slot: Slot) -> tuple[bool, float]:
    """Return whether an object fits into a slot, and how near the nearest of the others on its level is, m."""
    shapes = cell.shapes
    own, middle = shapes[thing].half, _middle(cell, thing, slot)
    others = [(shape, cell.see(other)) for other, shape in shapes.items() if other != thing]
    level = [(shape, pose) for shape, pose in others if abs(pose.position - middle)[2] < own[2] + shape.half[2] - ROOM]
    place = Rectangle(middle[:2], own[:2] + ROOM, slot.yaw)
    taken = [Rectangle(pose.position[:2], shape.half[:2], shape.yaw_near(pose.yaw, slot.yaw)) for shape, pose in level]
    nearest = min((float(np.hypot(*(pose.position - middle)[:2])) for _, pose in level), default=FAR)
    return not any(overlap(place, other) for other in taken), min(nearest, FAR)


def _await_grip(cell: Workcell) -> np.ndarray | None:
    """Wait until both pads press firmly for a while; return their forces in N, or None."""
    steady = 0
    for _ in range(round(GRIP_PATIENCE / CONTROL_PERIOD)):
        cell.wait(CONTROL_PERIOD)
        steady = steady + 1 if cell.watch.pad_forces.min() > FIRM else 0
        if steady >= STEADY_TIME / CONTROL_PERIOD:
            return cell.watch.pad_forces
    return None


def _placing(cell: Workcell, thing: str, slot: Slot) -> tuple[np.ndarray, float]:
    """Return the tool's position and yaw that put the held object, as it lies in the hand, into a slot.

    One that hangs askew touches down with an edge, and tips.
    """
    tool, held = cell.arm.tool(cell.reference), cell.measure(thing)
    symmetry = cell.scene.shapes[thing].symmetry
    turn = wrap(slot.yaw - held.yaw, symmetry) if symmetry else 0.0
    c, s = np.cos(turn), np.sin(turn)
    offset = held.position - tool.position
    lowest = offset[2] - cell.scene.shapes[thing].depth(held.rotation) + cell.scene.shapes[thing].half[2]
    turned = np.array([c * offset[0] - s * offset[1], s * offset[0] + c * offset[1], lowest - DROP])
    return _middle(cell, thing, slot) - turned, tool.yaw + turn
