"""Skills: how each symbolic action, `transit grasp transport release`, is carried out by motion and touch."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from prefplan.models.manipulation.action_costs import ACTION_KINDS
from sim.errors import BlockedError, SimulationError
from sim.geometry.rectangle import Rectangle, overlap
from sim.motion.trajectory import CONTROL_PERIOD, wrap
from sim.perception.grounding import AT_RADIUS, hand_over
from sim.simulation.workcell import Workcell
from sim.skills.transfer import travel
from sim.world.places import Slot
from sim.world.shapes import Grip, extent

HOVER_HEIGHT_M = 0.12
"""Height of the tool over a slot's centre before and after it grasps or releases: a held block clears a resting one."""

PASSAGE_CLEARANCE_M = 0.03
"""Least clearance at which the tool or its load passes over objects at rest."""

CLOSING_CHECKS = 4
"""Collision checks at this many widths as the hand closes: a finger, 11 mm thick, cannot pass a wall between two."""

FINGER_CLEARANCE_M = 0.0015
"""Least clearance of the fingers from other bodies: the arm comes to rest within 1 mm of its reference."""

CLOSE_TIME, OPEN_TIME = 0.35, 0.25
"""Duration of closing and of opening the hand, s."""

FIRM_GRIP_S, GRIP_TIMEOUT_S = 0.1, 0.6
"""How long a grip must stay firm, and how long to wait for that."""

SETTLE_TIME = 0.1
"""Wait before measuring an object in the hand and after letting it go, s."""

DROP_HEIGHT_M = 0.0005
"""Height from which an object is released, so that the hand does not press it onto the surface below."""

OBJECT_GAP_M, DISTANCE_CAP_M = 0.005, 0.1
"""Least gap between objects that rest side by side; and distance of centres beyond which slots are equally good."""

MOTION_THRESHOLD_M = 0.008
"""An object observed farther than this from its measured position is moving; sensor noise of 1 mm stays below."""

TOPPLED_TILT_RAD = np.radians(45)
"""An object tilted by more than this has fallen over, and is not grasped."""

GLOW_TIME = 1.5
"""How long a marking location works on an object released there, s."""


class SkillError(SimulationError):
    """A skill that ended without its effect; the message says why."""


def perform(cell: Workcell, action: str) -> None:
    """Carry out one symbolic action, e.g. `transport blue san`. After an error the arm is at rest.

    Raises:
        SkillError: it ended without its effect.
        BlockedError: bodies are in the way of the arm or of the fingers.
        SimulationError: the goal is out of reach.
    """
    kind, *arguments = action.split()
    SKILLS[kind](cell, *arguments)


def transit(cell: Workcell, location: str) -> None:
    """Bring the empty hand over a location and whatever is piled up there."""
    cell.watch.handle(None)
    slots = cell.scene.slots[location]
    centre = np.mean([slot.position for slot in slots], axis=0)
    middle = extent(cell.scene.shapes.values()).high / 2
    height = max(centre[2] + middle + HOVER_HEIGHT_M, _passage(cell))
    travel(cell, np.array([*centre[:2], height]), slots[0].yaw, height=_passage(cell))


def grasp(cell: Workcell, obj: str) -> None:
    """Lower the hand on the object below it, close it until both pads press the object firmly, and raise it."""
    slot, shape = _slot_below(cell, obj), cell.scene.shapes[obj]
    pose = cell.measure(obj)
    if pose.tilt > TOPPLED_TILT_RAD:
        raise BlockedError(f"{obj} fell over", ())
    cell.watch.handle(obj)
    yaw = shape.yaw_near(pose.yaw, slot.yaw)
    line, grip = _free_line(cell, pose.position, [(yaw + grip.turn, grip) for grip in shape.grip_variants])
    target, above = pose.position + [0.0, 0.0, grip.lift], pose.position + [0.0, 0.0, HOVER_HEIGHT_M]
    if cell.misses:
        cell.misses -= 1
        target = target + [0.0, 0.0, shape.height + OBJECT_GAP_M]
    cell.grip(grip.opening, CONTROL_PERIOD)
    yaw = _move(cell, above, [line, line + np.pi])
    if np.linalg.norm(cell.see(obj).position - pose.position) > MOTION_THRESHOLD_M:
        raise SkillError(f"{obj} does not lie still")
    _move(cell, target, [yaw])
    cell.grip(grip.width - cell.scene.robot.gripper.squeeze_m, CLOSE_TIME)
    forces = _await_grip(cell)
    if forces is None:
        cell.grip(grip.opening, OPEN_TIME)
    _move(cell, above, [yaw])
    if forces is None:
        raise SkillError(f"the fingers closed without a firm grip on {obj}")
    _check_held(cell, obj)
    cell.tell("grasped", object=obj, force=[round(float(force), 2) for force in forces])


def transport(cell: Workcell, obj: str, location: str) -> None:
    """Carry the held object over the location's free slot."""
    _check_held(cell, obj)
    slot = _free_slot(cell, obj, location)
    middle = _middle(cell, obj, slot)
    cell.watch.handle(obj)
    line, _ = _free_line(cell, middle, _putting(cell, obj, slot))
    cell.watch.handle(obj, aloft=True)
    travel(cell, middle + [0.0, 0.0, HOVER_HEIGHT_M], line, height=_passage(cell, obj))
    _check_held(cell, obj)


def release(cell: Workcell, obj: str, location: str) -> None:
    """Measure the object in the hand, lower it into the free slot, let go and raise the hand.

    Above the slot the object's pose in the tool frame is measured and corrected for, since it drifts while it is
    carried; and the slot is checked once more to be free.
    """
    _check_held(cell, obj)
    slot = _free_slot(cell, obj, location)
    cell.watch.handle(obj, aloft=True)
    cell.wait(SETTLE_TIME)
    position, yaw = _placing(cell, obj, slot)
    above = position + [0.0, 0.0, HOVER_HEIGHT_M]
    _move(cell, above, [yaw])
    _check_free(cell, obj, slot)
    position, yaw = _placing(cell, obj, slot)
    _check_held(cell, obj)
    cell.watch.handle(obj)
    _move(cell, position, [yaw])
    cell.wait(SETTLE_TIME)
    cell.grip(_grip(cell, obj).opening, OPEN_TIME)
    _move(cell, above, [yaw])
    cell.watch.handle(None)
    error = float(np.hypot(*(cell.measure(obj).position - slot.position)[:2]))
    cell.tell("placed", object=obj, location=location, error_mm=round(error * 1000, 2))
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
    """Return the first closing line, with its grip, on which the fingers close on the object without a collision.

    Args:
        cell: the running simulation.
        position: (3,) of the object's middle, m.
        options: lines, rad, and grips to try in turn.

    Raises:
        BlockedError: none is free.
    """
    blockers: set[str] = set()
    for line, grip in options:
        q, _ = cell.arm.reach(position + [0.0, 0.0, grip.lift], [line, line + np.pi])
        widths = np.linspace(grip.opening, grip.width, CLOSING_CHECKS)
        obstacles = {
            obj for width in widths for obj in cell.foresee(q, width=float(width), clearance=FINGER_CLEARANCE_M)
        }
        if not obstacles:
            return line, grip
        blockers |= obstacles
    raise BlockedError(f"no room for the fingers: they would touch {' and '.join(sorted(blockers))}", blockers)


def _grip(cell: Workcell, obj: str) -> Grip:
    """Return the grip in which the hand holds an object."""
    turn = cell.arm.tool(cell.reference).yaw - cell.see(obj).yaw
    return min(cell.scene.shapes[obj].grips, key=lambda grip: abs(wrap(turn - grip.turn, np.pi)))


def _putting(cell: Workcell, obj: str, slot: Slot) -> list[tuple[float, Grip]]:
    """Return the closing lines, each with its grip, at which the held object can be placed square to a slot."""
    grip, shape = _grip(cell, obj), cell.scene.shapes[obj]
    if shape.symmetry > np.pi / 2:
        return [(slot.yaw + grip.turn, grip)]
    return [(slot.yaw, grip), (slot.yaw + np.pi / 2, grip)]


def _middle(cell: Workcell, obj: str, slot: Slot) -> np.ndarray:
    """Return the centre of an object when it rests in a slot, on the objects that support it there now."""
    scene, floor = cell.scene, float(slot.position[2])
    below = [other.position[:2] for name in scene.model.location(slot.location).on for other in scene.slots[name]]
    tops = [
        cell.see(other).position[2] + shape.half[2]
        for other, shape in cell.shapes.items()
        if other != obj and any(np.hypot(*(cell.see(other).position[:2] - xy)) < AT_RADIUS for xy in below)
    ]
    return np.array([*slot.position[:2], max(tops, default=floor) + scene.shapes[obj].half[2]])


def _passage(cell: Workcell, held: str | None = None) -> float:
    """Return the height of the tool at which it and its load clear all objects at rest, m."""
    shapes = cell.shapes
    tops = [cell.see(obj).position[2] + shape.half[2] for obj, shape in shapes.items() if obj != held]
    below = shapes[held].half[2] if held else cell.scene.robot.gripper.fingertip_m
    return max(tops, default=0.0) + below + PASSAGE_CLEARANCE_M


def _slot_below(cell: Workcell, obj: str) -> Slot:
    """Return the slot at the hand's location where the object rests."""
    position = cell.see(obj).position - [0.0, 0.0, cell.scene.shapes[obj].half[2]]
    slots = [slot for row in cell.scene.slots.values() for slot in row]
    slot = min(slots, key=lambda slot: float(np.linalg.norm(position - slot.position)))
    if np.hypot(*(position - slot.position)[:2]) > AT_RADIUS or not hand_over(cell.scene, cell.data, slot.location):
        raise SkillError(f"{obj} is not below the hand")
    return slot


def _check_held(cell: Workcell, obj: str) -> None:
    if cell.held() != obj:
        raise SkillError(f"no contact force on both finger pads: {obj} is not held")


def _free_slot(cell: Workcell, obj: str, location: str) -> Slot:
    """Return the slot of a location farthest from the other objects on its level."""
    slot = max(cell.scene.slots[location], key=lambda slot: _clearance(cell, obj, slot))
    _check_free(cell, obj, slot)
    return slot


def _check_free(cell: Workcell, obj: str, slot: Slot) -> None:
    fits, nearest = _clearance(cell, obj, slot)
    if not fits:
        raise SkillError(f"no room for {obj} on {slot.location}: another object is {nearest * 1000:.0f} mm from it")


def _clearance(cell: Workcell, obj: str, slot: Slot) -> tuple[bool, float]:
    """Return whether an object fits into a slot, and the distance to the nearest other object on its level, m."""
    shapes = cell.shapes
    own, middle = shapes[obj].half, _middle(cell, obj, slot)
    others = [(shape, cell.see(other)) for other, shape in shapes.items() if other != obj]
    level = [
        (shape, pose)
        for shape, pose in others
        if abs(pose.position - middle)[2] < own[2] + shape.half[2] - OBJECT_GAP_M
    ]
    place = Rectangle(middle[:2], own[:2] + OBJECT_GAP_M, slot.yaw)
    taken = [Rectangle(pose.position[:2], shape.half[:2], shape.yaw_near(pose.yaw, slot.yaw)) for shape, pose in level]
    nearest = min((float(np.hypot(*(pose.position - middle)[:2])) for _, pose in level), default=DISTANCE_CAP_M)
    return not any(overlap(place, other) for other in taken), min(nearest, DISTANCE_CAP_M)


def _await_grip(cell: Workcell) -> np.ndarray | None:
    """Wait until the grip is firm for `FIRM_GRIP_S`; return the pads' contact forces in N, or None after a timeout."""
    steady = 0
    for _ in range(round(GRIP_TIMEOUT_S / CONTROL_PERIOD)):
        cell.wait(CONTROL_PERIOD)
        steady = steady + 1 if cell.watch.pad_forces.min() > cell.scene.robot.gripper.firm_force_n else 0
        if steady >= FIRM_GRIP_S / CONTROL_PERIOD:
            return cell.watch.pad_forces
    return None


def _placing(cell: Workcell, obj: str, slot: Slot) -> tuple[np.ndarray, float]:
    """Return the tool's position and yaw that put the held object, as it lies in the hand, into a slot.

    A tilted object would touch down with an edge and tip, so that its lowest point sets the height.
    """
    tool, held = cell.arm.tool(cell.reference), cell.measure(obj)
    symmetry = cell.scene.shapes[obj].symmetry
    turn = wrap(slot.yaw - held.yaw, symmetry) if symmetry else 0.0
    c, s = np.cos(turn), np.sin(turn)
    offset = held.position - tool.position
    lowest = offset[2] - cell.scene.shapes[obj].depth(held.rotation) + cell.scene.shapes[obj].half[2]
    turned = np.array([c * offset[0] - s * offset[1], s * offset[0] + c * offset[1], lowest - DROP_HEIGHT_M])
    return _middle(cell, obj, slot) - turned, tool.yaw + turn
