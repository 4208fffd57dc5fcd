"""The robot in a layout: slots in its reach, and what stands in its way at home."""

import copy
import itertools
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace

import mujoco
import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from sim.errors import SimulationError, collecting
from sim.external.user_scene import UserScene
from sim.geometry.rectangle import Rectangle
from sim.motion.kinematics import Arm
from sim.motion.trajectory import ToolPose
from sim.robots.import_mjcf import PREFIX
from sim.robots.robot import Robot
from sim.world.contacts import set_margins
from sim.world.fixtures import Block, blocks_of
from sim.world.places import Extent, Slot
from sim.world.shapes import about_z

HAND_SPACE_M, HAND_HEIGHT_M = 0.12, 0.35
"""Half width and height of the space over a slot that a hand pointing down needs at most, wrist included, m."""

HOME_CLEARANCE_M = 0.004
"""Least clearance of the robot from everything else at home, with its hand open, m."""

Slots = Mapping[str, tuple[Slot, ...]]


def _check_reach(arm: Arm, slot: Slot, height: float) -> None:
    """Raise `SimulationError` if a slot is behind the base, or no tilt of the hand reaches a height, m, over it."""
    robot = arm.robot
    distance, bearing = robot.polar(slot.position)
    where = f"locations.{slot.location}: {distance:.2f} m from the robot's base"
    if abs(bearing) > robot.max_bearing_rad:
        raise SimulationError(f"{where}, behind it: it turns {np.degrees(robot.max_bearing_rad):.0f} degrees each way")
    if _reaches_any(arm, _poses(arm, slot, height)):
        return
    if distance < robot.nearest_m:
        raise SimulationError(
            f"{where}, too near for its hand in any tilt; it reaches any place {robot.nearest_m:.2f} m away"
        )
    farthest = _farthest(arm, slot, height)
    above = slot.position[2] - robot.position[2]
    level = f"{abs(above):.2f} m {'above' if above > 0 else 'below'} its base"
    enough = f"at most {farthest:.2f} m" if farthest else f"nowhere does it reach {level}"
    raise SimulationError(f"{where}, beyond its reach: {enough} in this direction")


def _farthest(arm: Arm, slot: Slot, height: float) -> float:
    """Return how far from its base the robot reaches in the direction of a slot, m, to the centimetre; 0 if nowhere."""
    distance, base = arm.robot.polar(slot.position)[0], arm.robot.position
    direction = (slot.position - base) * [1, 1, 0] / distance

    def within(centimetres: int) -> bool:
        """Return whether it reaches so far."""
        nearer = replace(slot, position=base + direction * centimetres / 100)
        return _reaches_any(arm, _poses(arm, nearer, height))

    low, high = int(np.ceil(arm.robot.nearest_m * 100)), int(np.ceil(distance * 100))
    if not within(low):
        return 0.0
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if within(middle) else (low, middle)
    return low / 100


def reaches(arm: Arm, slot: Slot, height: float) -> bool:
    """Return whether the tool reaches a height, m, over a slot with its yaw."""
    return _reaches_any(arm, itertools.islice(_poses(arm, slot, height), 1))


def _poses(arm: Arm, slot: Slot, height: float) -> Iterator[ToolPose]:
    """Yield poses of the tool at a height, m, over a slot: with its yaw, then with other headings and tilts."""
    position, outwards = np.array([*slot.position[:2], height]), slot.position - arm.robot.position
    yield ToolPose.down(position, slot.yaw)
    across = ToolPose.down(position, float(np.arctan2(outwards[1], outwards[0])) + np.pi / 2)
    tilts = np.radians([0, 15, 30, 45, 60, 75, 90])
    for tilt, turn, side in itertools.product(tilts, (0.0, np.pi / 2), (-1.0, 1.0)):
        tilted = across.leaning(tilt, side * outwards * [1, 1, 0])
        yield replace(tilted, rotation=tilted.rotation @ about_z(turn))


def _reaches_any(arm: Arm, poses: Iterable[ToolPose]) -> bool:
    for pose in poses:
        with suppress(SimulationError):
            arm.reach(pose.symmetric_poses())
            return True
    return False


def out_of_reach(arm: Arm, model: ManipulationModel, slots: Slots, sizes: Mapping[str, Extent]) -> list[str]:
    """Return a message for each slot out of the robot's reach; it begins with its location's key.

    Not checked are levels of a stack that too few objects reach, and slots where the hand may come from the side: near
    a fixture, and anywhere in a user's own scene.
    """
    found: list[str] = []
    blocks = blocks_of(model.fixtures)
    for slot in (slot for row in slots.values() for slot in row):
        storeys, size = _storeys(model, slot.location), sizes[slot.location]
        without = storeys and storeys >= len(model.objects)
        if without or model.scene is not None or _is_enclosed(slot, blocks):
            continue
        # An object in a stack is lowest when the lowest objects carry it.
        height = float(slot.position[2]) - storeys * (size.high - size.low) + size.low / 2
        with collecting(found):
            _check_reach(arm, slot, height)
    return found


def _is_enclosed(slot: Slot, blocks: Iterable[Block]) -> bool:
    """Return whether a fixture stands beside or over a slot, so that the hand may have to come from the side."""
    around = Rectangle(slot.position[:2], np.full(2, HAND_SPACE_M), slot.yaw)
    low = float(slot.position[2])
    return any(block.meets(around, low, low + HAND_HEIGHT_M) for block in blocks)


def _storeys(model: ManipulationModel, location: str) -> int:
    return max((1 + _storeys(model, support) for support in model.location(location).on), default=0)


def faults_at_home(
    model: mujoco.MjModel, data: mujoco.MjData, robot: Robot, keys: Mapping[str, str], own: UserScene | None
) -> list[str]:
    """Return the faults of bodies that the robot would be inside of, or too near to, at home in the initial state.

    Parts of the robot that never move, such as its base, may touch what never moves either. `keys` are the scenario's
    keys by body; `own` is the user's own scene, or None.
    """
    model, data = copy.copy(model), copy.copy(data)
    is_robot = robot.bodies(model)
    set_margins(model, HOME_CLEARANCE_M * is_robot[model.geom_bodyid])
    mujoco.mj_collision(model, data)
    nearest: dict[int, tuple[float, int]] = {}
    for (one, other), distance in zip(model.geom_bodyid[data.contact.geom], data.contact.dist, strict=True):
        if is_robot[one] != is_robot[other]:
            link, body = (one, other) if is_robot[one] else (other, one)
            nearest[int(body)] = min(nearest.get(int(body), (float("inf"), -1)), (float(distance), int(link)))
    return [
        _fault(str(model.body(body).name), str(model.body(link).name).removeprefix(PREFIX), distance, keys, own)
        for body, (distance, link) in nearest.items()
    ]


def _fault(body: str, link: str, distance: float, keys: Mapping[str, str], own: UserScene | None) -> str:
    mm = 1000 * abs(distance)
    how = f"{mm:.1f} mm inside" if distance < 0 else f"only {mm:.1f} mm from"
    enough = "" if distance < 0 else f"; at least {1000 * HOME_CLEARANCE_M:g} mm"
    if body in keys:
        return f"{keys[body]}: the robot's {link} at home would be {how} it{enough}; move it away"
    other = own.words(body) if own is not None and own.holds(body) else f"the {body}"
    return f"robot: its {link} at home would be {how} {other}{enough}"
