"""Skills: how each symbolic action, `transit grasp transport release`, is carried out by motion and touch."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from prefplan.models.manipulation import ACTION_KINDS
from sim.errors import SimulationError
from sim.grounding import AT_RADIUS, hand_over
from sim.motion import CONTROL_PERIOD, wrap
from sim.places import Slot
from sim.workcell import Workcell

HOVER = 0.12
"""Height of the tool over a slot's centre before and after it works there, m: a held block clears one resting."""

CLEARANCE = 0.03
"""Least height at which the tool or what it holds passes over resting objects, m."""

DETOURS = (0.0, 0.1, 0.2)
"""By how much more the tool is raised to pass over what is not an object, e.g. a lamp, m."""

FORESIGHT = 10
"""Every so many joint references are looked at for obstacles before they are followed: every 0.1 s."""

OPENING = 0.07
"""Width of the open hand, m: 12 mm to either side of a block, and the fingers still fit into a bin."""

SQUEEZE = 0.015
"""How much narrower than the object the hand is commanded to close, m: about 15 N on either side."""

FIRM = 5.0
"""Force on each pad from which a grip counts as firm, N: a third of what is commanded."""

CLOSE_TIME, OPEN_TIME = 0.35, 0.25
"""Duration of closing and of opening the hand, s."""

STEADY_TIME, GRIP_PATIENCE = 0.1, 0.6
"""How long a grip must stay firm, and how long to wait for that, s."""

SETTLE_TIME = 0.1
"""Wait before measuring an object in the hand and after letting it go, s."""

DROP = 0.0005
"""Height from which an object is let go, m: so that it does not press on what it is put on."""

ROOM = 0.05
"""Least distance between the centres of objects that rest side by side, m: a block and 5 mm."""

GLOW_TIME = 1.5
"""How long a marking location works on what was released there, s."""


class SkillError(SimulationError):
    """A skill that ended without its effect; the message says why."""


def perform(cell: Workcell, action: str) -> None:
    """Carry out one symbolic action, e.g. `transport blue san`.

    Raises:
        SkillError: it did not work out; the arm rests and the simulation can go on.
        SimulationError: the arm cannot get there.
    """
    kind, *arguments = action.split()
    SKILLS[kind](cell, *arguments)


def transit(cell: Workcell, location: str) -> None:
    """Bring the empty hand over a location and whatever is piled up there."""
    cell.watch.handle(None)
    slots = cell.scene.slots[location]
    centre = np.mean([slot.position for slot in slots], axis=0)
    height = max(centre[2] + HOVER, _passage(cell))
    _travel(cell, np.array([*centre[:2], height]), slots[0].yaw)


def grasp(cell: Workcell, thing: str) -> None:
    """Lower the hand on the object below it, close until both pads feel it, and raise it."""
    slot = _slot_below(cell, thing)
    pose = cell.see(thing)
    above = np.array([*pose.position[:2], slot.position[2] + HOVER])
    cell.watch.handle(thing)
    cell.grip(OPENING, CONTROL_PERIOD)
    line = _free_line(cell, pose.position, _square_to(pose.yaw, slot.yaw))
    yaw = _move(cell, above, [line, line + np.pi])
    _move(cell, pose.position, [yaw])
    cell.grip(2 * cell.scene.half - SQUEEZE, CLOSE_TIME)
    forces = _await_grip(cell)
    if forces is None:
        cell.grip(OPENING, OPEN_TIME)
    _move(cell, above, [yaw])
    if forces is None:
        raise SkillError(f"the fingers closed without a firm grip on {thing}")
    _check_held(cell, thing)
    cell.tell("grasped", object=thing, force=[round(float(force), 2) for force in forces])


def transport(cell: Workcell, thing: str, location: str) -> None:
    """Carry the held object over the location's free slot."""
    _check_held(cell, thing)
    slot = _free_slot(cell, thing, location)
    cell.watch.handle(thing)
    line = _free_line(cell, slot.position, slot.yaw)
    cell.watch.handle(thing, aloft=True)
    _travel(cell, slot.position + [0.0, 0.0, HOVER], line, held=thing)
    _check_held(cell, thing)


def release(cell: Workcell, thing: str, location: str) -> None:
    """Measure the object in the hand, lower it into the free slot, let go and raise the hand.

    Above the slot the object's place in the hand is measured and made good, since it drifts while it is carried.
    """
    _check_held(cell, thing)
    slot = _free_slot(cell, thing, location)
    cell.watch.handle(thing, aloft=True)
    cell.wait(SETTLE_TIME)
    position, yaw = _placing(cell, thing, slot)
    above = position + [0.0, 0.0, HOVER]
    _move(cell, above, [yaw])
    position, yaw = _placing(cell, thing, slot)
    _check_held(cell, thing)
    cell.watch.handle(thing)
    _move(cell, position, [yaw])
    cell.wait(SETTLE_TIME)
    cell.grip(OPENING, OPEN_TIME)
    _move(cell, above, [yaw])
    cell.watch.handle(None)
    error = float(np.hypot(*(cell.see(thing).position - slot.position)[:2]))
    cell.tell("placed", object=thing, location=location, error_mm=round(error * 1000, 2))
    if cell.scene.model.location(location).marks:
        cell.glowing = list(cell.scene.slots).index(location)
        cell.wait(GLOW_TIME)
        cell.glowing = -1


SKILLS: dict[str, Callable[..., None]] = dict(zip(ACTION_KINDS, (transit, grasp, transport, release), strict=True))


def _move(cell: Workcell, position: np.ndarray, yaws: list[float]) -> float:
    """Move the tool to a position nearby, straight up or down; return which of the yaws it took."""
    goal, yaw = cell.arm.reach(position, yaws)
    cell.follow(cell.arm.move(cell.reference, goal, position, yaw, height=0.0))
    return yaw


def _travel(cell: Workcell, position: np.ndarray, line: float, *, held: str | None = None) -> None:
    """Move the tool to a position far away, over everything in between.

    Raises:
        SkillError: the way is blocked even at the greatest height.
    """
    goal, yaw = cell.arm.reach(position, [line, line + np.pi])
    height = _passage(cell, held)
    for raised in DETOURS:
        references = cell.arm.move(cell.reference, goal, position, yaw, height=height + raised)
        ahead = [*references[::FORESIGHT], references[-1]]
        obstacles = {name for q in ahead for name in cell.foresee(q)}
        if not obstacles:
            cell.follow(references)
            return
    raise SkillError(f"the way is blocked by {' and '.join(sorted(obstacles))}")


def _free_line(cell: Workcell, position: np.ndarray, line: float) -> float:
    """Return the closing line, this or the one across it, at which the open fingers touch nothing but the object.

    Raises:
        SkillError: neither is free.
    """
    for option in (line, line + np.pi / 2):
        q, _ = cell.arm.reach(position, [option, option + np.pi])
        obstacles = cell.foresee(q, width=OPENING)
        if not obstacles:
            return option
    raise SkillError(f"no room for the fingers: they would touch {' and '.join(obstacles)}")


def _square_to(yaw: float, line: float) -> float:
    """Return the heading of a cube's faces, known up to 90 degrees, that is nearest to a line."""
    return yaw + np.pi / 2 * round((line - yaw) / (np.pi / 2))


def _passage(cell: Workcell, held: str | None = None) -> float:
    """Return the height at which the tool, and what it holds, passes over everything that rests."""
    tops = [cell.see(thing.name).position[2] for thing in cell.scene.model.objects if thing.name != held]
    return max(tops, default=0.0) + 2 * cell.scene.half + CLEARANCE


def _slot_below(cell: Workcell, thing: str) -> Slot:
    """Return the slot at the hand's location where the object rests."""
    position = cell.see(thing).position
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
    others = [cell.see(other.name).position for other in cell.scene.model.objects if other.name != thing]

    def room(slot: Slot) -> float:
        level = [p for p in others if abs(p[2] - slot.position[2]) < 2 * cell.scene.half]
        return min((float(np.hypot(*(p - slot.position)[:2])) for p in level), default=np.inf)

    slot = max(cell.scene.slots[location], key=lambda slot: min(room(slot), 2 * ROOM))
    if room(slot) < ROOM:
        raise SkillError(f"no room for {thing} on {location}: another object is {room(slot) * 1000:.0f} mm from it")
    return slot


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
    """Return the tool's position and yaw that put the held object, as it lies in the hand, into a slot."""
    tool, held = cell.arm.tool(cell.reference), cell.see(thing)
    turn = wrap(slot.yaw - held.yaw, np.pi / 2)
    c, s = np.cos(turn), np.sin(turn)
    offset = held.position - tool.position
    turned = np.array([c * offset[0] - s * offset[1], s * offset[0] + c * offset[1], offset[2] - DROP])
    return slot.position - turned, tool.yaw + turn
