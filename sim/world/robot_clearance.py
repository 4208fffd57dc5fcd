"""The robot in a layout: slots in its reach, lamps that it clears, and what stands in its way at home."""

import copy
import functools
import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import mujoco
import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from sim.errors import SimulationError, collecting
from sim.external.user_scene import UserScene
from sim.geometry.mjcf import yaw_quat
from sim.geometry.rectangle import Rectangle, overlap
from sim.motion.kinematics import Arm
from sim.motion.trajectory import ToolPose
from sim.robots.import_mjcf import PREFIX
from sim.robots.robot import Robot
from sim.world.clearance import space
from sim.world.contacts import set_margins
from sim.world.fixtures import blocks_of
from sim.world.places import LAMP_HALF_M, Extent, Slot, Station
from sim.world.shapes import about_z

LAMP_DISTANCES_M = (0.19, 0.24, 0.29)
"""Distances to try from the nearest slot to a lamp's post, m: the hand hit one at 11 cm and cleared one at 17 cm."""

LAMP_TOP_M = 0.235
"""Greatest height of a lamp's head above the table, m."""

LAMP_HEAD_M = np.array([0.045, 0.086])
"""Half sides of a lamp's head seen from above, with 6 mm to spare, m."""

HAND_SPACE_M, HAND_HEIGHT_M = 0.12, 0.35
"""Half width and height of the space over a slot that a hand pointing down needs at most, wrist included, m."""

HOME_CLEARANCE_M = 0.004
"""Least clearance of the robot, m: at home, with its hand open, from everything else, and at a slot from lamps."""

Slots = Mapping[str, tuple[Slot, ...]]


def _configuration(arm: Arm, slot: Slot, height: float) -> np.ndarray:
    """Return a configuration with the tool at a height, m, over a slot, from straight above if that is possible.

    Raises `SimulationError` where the slot is behind the base, or out of reach with any tilt of the hand.
    """
    robot = arm.robot
    distance, bearing = robot.polar(slot.position)
    where = f"locations.{slot.location}: {distance:.2f} m from the robot's base"
    if abs(bearing) > robot.max_bearing_rad:
        raise SimulationError(f"{where}, behind it: it turns {np.degrees(robot.max_bearing_rad):.0f} degrees each way")
    if (q := _first_reached(arm, _poses(arm, slot, height))) is not None:
        return q
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
        return _first_reached(arm, _poses(arm, nearer, height)) is not None

    low, high = int(np.ceil(arm.robot.nearest_m * 100)), int(np.ceil(distance * 100))
    if not within(low):
        return 0.0
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if within(middle) else (low, middle)
    return low / 100


def reach(arm: Arm, slot: Slot, height: float) -> np.ndarray | None:
    """Return a configuration with the tool at a height, m, over a slot and with its yaw; None if there is none."""
    return _first_reached(arm, itertools.islice(_poses(arm, slot, height), 1))


def _poses(arm: Arm, slot: Slot, height: float) -> Iterator[ToolPose]:
    """Yield poses of the tool at a height, m, over a slot: with its yaw, then with other headings and tilts."""
    position, outwards = np.array([*slot.position[:2], height]), slot.position - arm.robot.position
    yield ToolPose.down(position, slot.yaw)
    across = ToolPose.down(position, float(np.arctan2(outwards[1], outwards[0])) + np.pi / 2)
    tilts = np.radians([0, 15, 30, 45, 60, 75, 90])
    for tilt, turn, side in itertools.product(tilts, (0.0, np.pi / 2), (-1.0, 1.0)):
        tilted = across.leaning(tilt, side * outwards * [1, 1, 0])
        yield replace(tilted, rotation=tilted.rotation @ about_z(turn))


def _first_reached(arm: Arm, poses: Iterable[ToolPose]) -> np.ndarray | None:
    for pose in poses:
        with suppress(SimulationError):
            return arm.reach(pose.symmetric_poses())[0]
    return None


class RobotAtSlots:
    """The robot at each slot of a layout.

    Attributes:
        out_of_reach: a message for each slot that is out of reach; it begins with its location's key.
    """

    def __init__(
        self,
        arm: Arm,
        model: ManipulationModel,
        stations: Sequence[Station],
        slots: Slots,
        sizes: Mapping[str, Extent],
    ):
        """Find a configuration for every slot within reach, and the messages about the others.

        Not checked are levels of a stack that too few objects reach, and slots where the hand may come from the side:
        near a fixture, and anywhere in a user's own scene.
        """
        self._robot, self._sizes, self._stations, self._slots = arm.robot, sizes, stations, slots
        self._blocks = blocks_of(model.fixtures)
        self.out_of_reach: list[str] = []
        self._configurations: list[tuple[str, np.ndarray]] = []
        for slot in (slot for row in slots.values() for slot in row):
            storeys, size = _storeys(model, slot.location), sizes[slot.location]
            without = storeys and storeys >= len(model.objects)
            if without or model.scene is not None or self._enclosed(slot):
                continue
            # An object in a stack is lowest when the lowest objects carry it.
            height = float(slot.position[2]) - storeys * (size.high - size.low) + size.low / 2
            with collecting(self.out_of_reach):
                self._configurations.append((slot.location, _configuration(arm, slot, height)))

    def _enclosed(self, slot: Slot) -> bool:
        """Return whether a fixture stands beside or over a slot, so that the hand may have to come from the side."""
        around = Rectangle(slot.position[:2], np.full(2, HAND_SPACE_M), slot.yaw)
        low = float(slot.position[2])
        return any(block.meets(around, low, low + HAND_HEIGHT_M) for block in self._blocks)

    def lamp_foot(self, station: Station) -> np.ndarray:
        """Return the (2,) foot of a station's lamp, m: clear of the robot, near the station, and away from the base.

        Raises `SimulationError` if there is no space for it.
        """
        centre = station.outline.centre
        x, y = centre - self._robot.position[:2]
        outwards = float(np.arctan2(y, x))
        turns = np.radians([0, 30, -30, 60, -60, 90, -90, 120, -120])
        for distance, turn in itertools.product(LAMP_DISTANCES_M, turns):
            direction = np.array([np.cos(outwards + turn), np.sin(outwards + turn)])
            reach = max(float((slot.position[:2] - centre) @ direction) for slot in station.slots)
            foot = centre + direction * (reach + distance)
            stand = Rectangle(foot, np.full(2, LAMP_HALF_M), outwards + turn)
            nearest = min(float(np.hypot(*(slot.position[:2] - foot))) for row in self._slots.values() for slot in row)
            if nearest < LAMP_DISTANCES_M[0] - LAMP_HALF_M / 2:
                continue
            if any(overlap(stand, space(at).outline) for at in self._stations):
                continue
            # The foot is within these sides.
            head = Rectangle(foot, LAMP_HEAD_M, outwards + turn)
            if any(block.meets(head, 0.0, LAMP_TOP_M) for block in self._blocks):
                continue
            if self._is_clear_of_lamp(head):
                return foot
        raise SimulationError(
            f"locations.{station.name}: no room for its lamp {LAMP_DISTANCES_M[0]:.2f} m away; move other locations off"
        )

    def _is_clear_of_lamp(self, head: Rectangle) -> bool:
        """Return whether the robot at every slot, its hand open as for the objects there, clears a lamp's head."""
        data = self._beside_lamp
        data.mocap_pos[0], data.mocap_quat[0] = [*head.centre, LAMP_TOP_M / 2], yaw_quat(head.yaw)
        for location, q in self._configurations:
            self._robot.put(data, q, width=self._sizes[location].opening)
            mujoco.mj_kinematics(data.model, data)
            mujoco.mj_collision(data.model, data)
            if data.ncon:
                return False
        return True

    @functools.cached_property
    def _beside_lamp(self) -> mujoco.MjData:
        """The robot and a lamp's head, with contacts between the two alone."""
        spec = self._robot.spec()
        lamp = spec.worldbody.add_body(mocap=True)
        lamp.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[*LAMP_HEAD_M, LAMP_TOP_M / 2])
        spec.compiler.discardvisual = True
        model = spec.compile()
        model.geom_margin[:] = model.body_margin[:] = HOME_CLEARANCE_M
        return mujoco.MjData(model)


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
