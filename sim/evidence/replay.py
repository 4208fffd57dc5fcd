"""The world of a logged run, rebuilt from the log alone, and the propositions that its recorded frames show.

This checks `sim.perception`, and shares nothing with it: objects rest on the shapes that they touch, and an object is
held if both pads touch and press it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import mujoco
import numpy as np

from prefplan.scenario.decode import Scenario
from sim.evidence.log import Log
from sim.evidence.rebuilt import built, described, perturbed_as_said, refusing, require_fitting, words_for
from sim.geometry.mjcf import columns, is_solid, solid_geoms
from sim.simulation.recorder import COMMANDS_PER_UNIT
from sim.simulation.run import FRAME_RATE_HZ

AT_LOCATION_M = 0.045
"""Greatest horizontal distance of an object at a location from the centre of a slot."""

CONTACT_DISTANCE_M = 0.002
"""Shapes nearer than this are in contact: distances of resting objects vary by micrometres."""

UPRIGHT_TILT_RAD = np.radians(20)
"""Greatest tilt of an object that stands."""

AT_HEIGHT_M = 0.008
"""Greatest difference of the height of an object at a location from that at which it stands there: one that leans on
something may touch the surface and yet be higher."""

NOISE_FACTOR = 2
"""Greatest error of a measured position in multiples of `RecordedWorld.noise`: a measurement averages ten observations,
so that these are six standard deviations, and four of the distance between two objects."""

HOLD_FORCE_N = 0.5
"""Least contact force of each pad on a held object: about the weight of a default cube."""

PRESS_MEMORY_FRAMES = round(0.2 * FRAME_RATE_HZ)
"""Number of frames that a contact force counts for: simulated contacts flicker."""


class RecordedWorld:
    """The world of a log, at one frame at a time.

    Attributes:
        scenario: read from the log.
        model: its manipulation model.
        actions: of the run, as the model has them.
        mujoco: the scene's MuJoCo model.
        robot: whose arm moved.
        scene: perturbed as the log's setting says.
        other_shapes: whether the arm had other shapes in the run than it has here.
        start: (nq,) positions at which the run begins, by its seed.
        noise: standard deviation of an observed coordinate, m.
        bias: (3,) constant error of every observed position, by the seed, m.
        objects: of the scenario, and those that faults added.
        grips: (T,) commands of the gripper.
        pad_forces: (T, pads) contact force on each of the gripper's pads, N, as far as it was simulated again.
        arm_shapes: which shapes of the arm are checked for contacts, in words.

    Raises:
        LogError: (on construction) the scenario in the log cannot be read or built, or its frames do not fit into it.
    """

    def __init__(self, log: Log, scenario: Scenario | None = None) -> None:
        """Build the scene of a scenario, or if it is None, that which the log describes."""
        about = log.about
        self._log = log
        self.scenario = scenario or described(about)
        scene = built(self.scenario, about)
        self.other_shapes, self.arm_shapes = scene.has_meshes != about.meshes, words_for(scene)
        self.scene, self.start, self.noise, self.bias = perturbed_as_said(scene, about)
        self.model, self.mujoco, self.robot = self.scene.model, self.scene.mujoco, self.scene.robot
        self.objects = (*(obj.name for obj in self.model.objects), *self.scene.spares)
        require_fitting(log, self.scene, self.objects)
        with refusing("the log is broken"):
            self.actions = tuple(self.model.action(action.action) for action in about.actions)
        self._data, self._frame = mujoco.MjData(self.mujoco), 0
        self._geoms = {obj: solid_geoms(self.mujoco, obj).tolist() for obj in self.objects}
        bodies = (self.mujoco.body_weldid == 0) & ~self.robot.bodies(self.mujoco)
        self._fixed = np.flatnonzero(is_solid(self.mujoco) & bodies[self.mujoco.geom_bodyid]).tolist()
        self._pads = [int(self.mujoco.geom(name).id) for name in self.robot.gripper.pads]
        steps = np.rint(log.times / self.mujoco.opt.timestep).astype(int) - 1
        sent = np.append(log.controls[:, self.mujoco.actuator(self.robot.gripper.actuator).id], 0)
        self.pad_forces = np.zeros((len(log.times), len(self._pads)))
        self.grips = sent[steps.clip(0, max(0, len(sent) - 2))] / COMMANDS_PER_UNIT

    def path(self, obj: str) -> np.ndarray:
        """Return the (T, 3) recorded positions of an object's centre, m."""
        pose, _ = columns(self.mujoco, obj)
        return self._log.qpos[:, pose][:, :3]

    def frame_at(self, time: float) -> int:
        """Return the index of the last frame up to a time, s."""
        return max(0, int(np.searchsorted(self._log.times, time + 1e-9)) - 1)

    def worked(self, location: str, *, start: float, end: float) -> bool:
        """Return whether a marking location was at work between two times, s."""
        index = [place.name for place in self.model.locations].index(location)
        during = (self._log.times >= start) & (self._log.times <= end)
        return bool(np.any(self._log.glow[during] == index))

    def show(self, frame: int) -> None:
        """Set the positions of a frame."""
        self._frame = frame
        self._data.qpos[:] = self._log.qpos[frame]
        mujoco.mj_kinematics(self.mujoco, self._data)

    def pointed_at(self, frame: int, distances: np.ndarray) -> np.ndarray:
        """Return the (K, 3) points at K distances ahead of the tool in a frame, m."""
        self.show(frame)
        tool = self._data.site(self.robot.tool)
        return np.asarray(tool.xpos + distances[:, None] * tool.xmat.reshape(3, 3)[:, 2])

    def held(self) -> str | None:
        """Return the object in contact with all pads that they pressed within `PRESS_MEMORY_FRAMES`, or None.

        Only frames count in which the gripper was commanded to hold.
        """
        recent = slice(max(0, self._frame - PRESS_MEMORY_FRAMES), self._frame + 1)
        pressed = self.pad_forces[recent].min(axis=1) > HOLD_FORCE_N
        if not any(pressed & [self.robot.gripper.holds(command) for command in self.grips[recent]]):
            return None
        return next(
            (name for name, parts in self._geoms.items() if all(self._touch(parts, [pad]) for pad in self._pads)), None
        )

    def fallen(self) -> set[str]:
        """Return the objects that are below the table top."""
        return {obj for obj in self._geoms if self._data.body(obj).xpos[2] <= 0}

    def resting(self, held: str | None, *, doubt: int = 0) -> dict[str, str]:
        """Return the location of every object that rests at one, as the camera shows it, except the held one.

        Where more objects rest than a location has slots, only the nearest to a slot count.

        Args:
            held: the object in the hand.
            doubt: 1 for those that an observation with noise may show there, -1 for those that any one shows there.
        """
        elsewhere = {held, *self.fallen()}
        objects = [obj for obj in self._geoms if obj not in elsewhere]
        found = {obj: place for obj in objects if (place := self._rests(obj, doubt)) is not None}
        for location in self.model.locations:
            name = location.name
            there = [obj for obj, place in found.items() if place == name]
            there.sort(key=lambda obj: self._distances(obj)[name])
            for obj in there[location.capacity :]:
                del found[obj]
        return found

    def _rests(self, obj: str, doubt: int) -> str | None:
        """Return the location at which an object rests, whatever its capacity, or None.

        The object stands near a slot, on what stands there or on the bare table. It stands on an object that rests at
        another location, for a location on others, and near the middle of the objects there.
        """
        if not self._stands(obj):
            return None
        slack = doubt * NOISE_FACTOR * self.noise
        distances, underside = self._distances(obj), self._observed(obj)[2] - self._half_height(obj)
        for place in sorted(distances, key=distances.__getitem__):
            if distances[place] > 2 * AT_LOCATION_M:
                return None
            supports, slot = self.model.location(place).on, self.scene.slots[place][0]
            far, floors = distances[place], [float(slot.position[2])]
            if supports:
                under = {self._rests(below, doubt): below for below in self._carriers(obj)}
                where = [
                    self._observed(under[name]) if name in under else self.scene.slots[name][0].position
                    for name in supports
                ]
                far = float(np.hypot(*(np.mean(where, axis=0) - self._observed(obj))[:2]))
                carriers = [under[name] for name in supports if name in under]
                floors = [self._observed(below)[2] + self._half_height(below) for below in carriers]
            elif not self._touch(self._geoms[obj], self._fixed):
                continue
            level = any(abs(underside - floor) < AT_HEIGHT_M + slack for floor in floors)
            if level and far < AT_LOCATION_M + slack:
                return place
        return None

    def _observed(self, obj: str) -> np.ndarray:
        """Return the (3,) position of an object with the camera's constant error, m."""
        return np.asarray(self._data.body(obj).xpos + self.bias)

    def _half_height(self, obj: str) -> float:
        return float(self.scene.shapes[obj].half[2])

    def _touch(self, geoms: Iterable[int], others: Iterable[int]) -> bool:
        return any(touching(self._data, geom, other) for geom, other in itertools.product(geoms, others))

    def _stands(self, obj: str) -> bool:
        """Return whether an object stands upright; a box may stand on any face on which it has its upright height."""
        geom = self._geoms[obj][0]
        steep = np.abs(self._data.body(obj).xmat.reshape(3, 3)[2])
        upright = np.array([False, False, True])
        if self.mujoco.geom_type[geom] == mujoco.mjtGeom.mjGEOM_BOX and len(self._geoms[obj]) == 1:
            upright = np.isclose(self.mujoco.geom_size[geom], self.mujoco.geom_size[geom][2])
        return bool(steep[upright].max() > np.cos(UPRIGHT_TILT_RAD))

    def _distances(self, obj: str) -> dict[str, float]:
        """Return the horizontal distance of an object from the nearest slot of each location, m."""
        centre = self._observed(obj)[:2]
        return {
            name: min(float(np.hypot(*(slot.position[:2] - centre))) for slot in row)
            for name, row in self.scene.slots.items()
        }

    def _carriers(self, obj: str) -> list[str]:
        """Return the objects that an object touches and whose centres are lower than its own."""
        heights = {name: self._data.body(name).xpos[2] for name in self._geoms}
        lower = [name for name in self._geoms if heights[name] < heights[obj] - CONTACT_DISTANCE_M]
        return [name for name in lower if self._touch(self._geoms[obj], self._geoms[name])]


def touching(data: mujoco.MjData, geom: int, other: int) -> bool:
    """Return whether two geoms are nearer than `CONTACT_DISTANCE_M`."""
    far = mujoco.mj_geomDistance(data.model, data, geom, other, 2 * CONTACT_DISTANCE_M, None)
    return bool(far < CONTACT_DISTANCE_M)
