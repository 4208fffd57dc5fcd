"""The robot at the slots of a layout: each slot in reach and free of collision, and lamps that the robot clears."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import mujoco
import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from sim.errors import SimulationError, collecting
from sim.geometry.mjcf import yaw_quat
from sim.geometry.rectangle import Rectangle, overlap
from sim.motion.kinematics import Arm
from sim.motion.trajectory import ToolPose
from sim.robots.gripper import PAD_CLEARANCE_M
from sim.world.clearance import covered
from sim.world.fixtures import add_fixture, blocks_of, body_name
from sim.world.furniture import add_station
from sim.world.materials import add_studio
from sim.world.places import LAMP_DISTANCES_M, LAMP_HALF_M, LAMP_HEAD_M, LAMP_TOP_M, Slot, Station, under
from sim.world.shapes import Extent

HAND_SPACE_M, HAND_HEIGHT_M = 0.12, 0.35
"""Half width and height of the space over a slot that a hand pointing down needs at most, wrist included, m."""

CARRYING_HEIGHT_M = 0.08
"""Least height of the tool over other objects while it carries one over them, m."""

SLOT_CLEARANCE_M = 0.004
"""Least clearance of the robot at a slot from fixtures and from objects in other slots, m."""

LAMP_BODY = "lamp head"
"""Name of the body that represents a lamp's head at each foot that is tried."""

Slots = Mapping[str, tuple[Slot, ...]]


def _configuration(arm: Arm, slot: Slot, *, grasping: float, carrying: float) -> np.ndarray:
    """Return a configuration in which the hand grasps the lowest object in a slot.

    Args:
        arm: of the robot.
        slot: on the table or on objects.
        grasping: height of the tool in the grasp, m.
        carrying: height of the tool as it passes over the stack there, m.

    Raises:
        SimulationError: the slot is out of the hand's reach from above.
    """
    robot = arm.robot
    distance, bearing = robot.polar(slot.position)
    near = distance < robot.nearest_m
    # Rounding to the nearest could show a distance that is slightly too small as sufficient.
    shown = np.floor(100 * distance) / 100 if near else distance
    where = f"locations.{slot.location}: {shown:.2f} m from the robot's base"
    if near:
        raise SimulationError(f"{where}, too near: at least {robot.nearest_m:.2f} m")
    if abs(bearing) > robot.max_bearing_rad:
        raise SimulationError(f"{where}, behind it: it turns {np.degrees(robot.max_bearing_rad):.0f} degrees each way")
    q = reach(arm, slot, grasping)
    if q is None or reach(arm, slot, carrying) is None:
        stack = "" if q is None else f" when it passes over a stack {carrying - CARRYING_HEIGHT_M:.2f} m high"
        farthest = _farthest(arm, slot, (grasping, carrying))
        above = slot.position[2] - robot.position[2]
        height = f"{abs(above):.2f} m {'above' if above > 0 else 'below'} its base"
        enough = f"at most {farthest:.2f} m" if farthest else f"nowhere does it reach {height}"
        raise SimulationError(f"{where}, beyond its reach{stack}: {enough} in this direction")
    return q


def _farthest(arm: Arm, slot: Slot, heights: tuple[float, ...]) -> float:
    """Return how far from its base the robot reaches in the direction of a slot, m, to the centimetre; 0 if nowhere."""
    distance, base = arm.robot.polar(slot.position)[0], arm.robot.position
    direction = (slot.position - base) * [1, 1, 0] / distance

    def within(centimetres: int) -> bool:
        """Return whether it reaches so far."""
        nearer = replace(slot, position=base + direction * centimetres / 100)
        return all(reach(arm, nearer, height) is not None for height in heights)

    low, high = int(np.ceil(arm.robot.nearest_m * 100)), int(np.ceil(distance * 100))
    if not within(low):
        return 0.0
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if within(middle) else (low, middle)
    return low / 100


def reach(arm: Arm, slot: Slot, height: float) -> np.ndarray | None:
    """Return a configuration with the tool at a height, m, over a slot and with its yaw; None if there is none."""
    pose = ToolPose.down(np.array([*slot.position[:2], height]), slot.yaw)
    try:
        return arm.reach(pose.symmetric_poses())[0]
    except SimulationError:
        return None


class RobotAtSlots:
    """The robot at each slot of a layout, among its fixtures and an object in every other slot."""

    def __init__(
        self,
        arm: Arm,
        model: ManipulationModel,
        stations: Sequence[Station],
        slots: Slots,
        sizes: Mapping[str, Extent],
    ):
        """Compile the robot with stations, fixtures and a box for the largest object in every slot."""
        self._manipulation, self._robot, self._sizes = model, arm.robot, sizes
        self._stations, self._slots = stations, slots
        self._blocks = blocks_of(model.fixtures)
        self._find_configurations(arm, slots)
        spec = arm.robot.spec()
        add_studio(spec, target=np.zeros(3), span=1.0)  # for the materials of the fixtures
        for station in stations:
            add_station(spec, station)
        for fixture in model.fixtures:
            add_fixture(spec, fixture)
        self._fixtures = {body_name(fixture.name) for fixture in model.fixtures}
        self._locations = {f"{station.name}_base": (station.name, repr(station.name)) for station in stations}
        for slot in (slot for row in slots.values() for slot in row):
            name = f"{slot.location} {slot.index}"
            self._locations[name] = (slot.location, f"an object at {slot.location!r}")
            size = sizes[slot.location]
            half = np.array([*size.half, size.high / 2])
            body = spec.worldbody.add_body(name=name, pos=slot.position + [0, 0, half[2]], quat=yaw_quat(slot.yaw))
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=half)
        lamp = spec.worldbody.add_body(name=LAMP_BODY, mocap=True, pos=[0, 0, -10])
        lamp.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[*LAMP_HEAD_M, LAMP_TOP_M / 2])
        spec.compiler.discardvisual = True
        self._model = spec.compile()
        self._model.geom_margin[:] = self._model.body_margin[:] = SLOT_CLEARANCE_M
        self._data = mujoco.MjData(self._model)

    def _find_configurations(self, arm: Arm, slots: Slots) -> None:
        """Find a configuration for every slot within reach, and the faults of the others.

        Not checked are levels of a stack that too few objects reach, and slots where the hand may come from the side:
        near a fixture, and anywhere in a user's own scene.
        """
        self._configurations: list[tuple[str, np.ndarray]] = []
        self._out_of_reach: list[str] = []
        for slot in (slot for row in slots.values() for slot in row):
            storeys, size = _storeys(self._manipulation, slot.location), self._sizes[slot.location]
            without = storeys and storeys >= len(self._manipulation.objects)
            if without or self._manipulation.scene is not None or self._enclosed(slot):
                continue
            # An object in a stack is lowest when the lowest objects carry it.
            grasping = float(slot.position[2]) - storeys * (size.high - size.low) + size.low / 2
            with collecting(self._out_of_reach):
                top = float(slot.position[2]) + size.high
                q = _configuration(arm, slot, grasping=grasping, carrying=top + CARRYING_HEIGHT_M)
                self._configurations.append((slot.location, q))

    def faults(self, *, known: Collection[frozenset[str]]) -> list[str]:
        """Return the faults of slots that are out of reach, or at which the robot would collide with another location.

        Args:
            known: pairs of locations whose collision is reported already.
        """
        found: dict[tuple[str, str], str] = {}
        for location, q in self._configurations:
            for link, other in self._touches(location, q, tight=True):
                if other in self._fixtures:
                    continue
                there, words = self._locations[other]
                if there == location or self._stacked(location, there) or frozenset((location, there)) in known:
                    continue
                told = f"locations.{location}: the robot's {link} would touch {words}; move them apart"
                found.setdefault((location, words), told)
        return [*self._out_of_reach, *found.values()]

    def _enclosed(self, slot: Slot) -> bool:
        """Return whether a fixture stands beside or over a slot, so that the hand may have to come from the side."""
        around = Rectangle(slot.position[:2], np.full(2, HAND_SPACE_M), slot.yaw)
        low = float(slot.position[2])
        return any(block.meets(around, low, low + HAND_HEIGHT_M) for block in self._blocks)

    def lamp_foot(self, station: Station) -> np.ndarray:
        """Return the (2,) foot of a station's lamp, m: clear of the robot, near the station, and away from the base.

        Raises:
            SimulationError: there is no space for it.
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
            if any(overlap(stand, covered(at)) for at in self._stations):
                continue
            head = Rectangle(foot, np.maximum(LAMP_HEAD_M, LAMP_HALF_M), outwards + turn)
            if any(block.meets(head, 0.0, LAMP_TOP_M) for block in self._blocks):
                continue
            if self._is_clear_of_lamp(Rectangle(foot, LAMP_HEAD_M, outwards + turn)):
                return foot
        raise SimulationError(
            f"locations.{station.name}: no room for its lamp {LAMP_DISTANCES_M[0]:.2f} m away; move other locations off"
        )

    def _is_clear_of_lamp(self, head: Rectangle) -> bool:
        """Return whether the robot at every slot clears a lamp's head."""
        self._data.mocap_pos[0] = [*head.centre, LAMP_TOP_M / 2]
        self._data.mocap_quat[0] = yaw_quat(head.yaw)
        return not any(other == LAMP_BODY for where, q in self._configurations for _, other in self._touches(where, q))

    def _touches(self, location: str, q: np.ndarray, *, tight: bool = False) -> list[tuple[str, str]]:
        """Return pairs of a link of the robot, its hand open as for a location, and a body that it is too near to.

        With `tight`, the hand opens no wider than for the largest object where space is tight.
        """
        model, data = self._model, self._data
        width = self._sizes[location].opening
        if tight:
            width = min(width, 2 * float(self._sizes[location].half.max()) + 2 * PAD_CLEARANCE_M)
        self._robot.put(data, q, width=width)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        of_robot = self._robot.bodies(model)
        bodies = model.geom_bodyid[data.contact.geom.reshape(-1, 2)]
        pairs = [(a, b) if of_robot[a] else (b, a) for a, b in bodies]
        return [(model.body(link).name, model.body(other).name) for link, other in pairs]

    def _stacked(self, location: str, other: str) -> bool:
        """Return whether one location lies above the other."""
        return other in under(self._manipulation, location) or location in under(self._manipulation, other)


def _storeys(model: ManipulationModel, location: str) -> int:
    return max((1 + _storeys(model, support) for support in model.location(location).on), default=0)
