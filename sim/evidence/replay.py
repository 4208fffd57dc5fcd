"""The world of a logged run, rebuilt from the log alone, and the propositions that its recorded frames show.

This checks `sim.perception`, and shares nothing with it: an object rests where its underside is level with a surface,
and is held if both pads touch and press it.
"""

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from prefplan.logic.good_prefix import Label
from prefplan.models.manipulation.model import Location
from prefplan.models.manipulation.symbolic import at, holding
from prefplan.scenario.decode import Scenario
from sim.evidence.log import Log
from sim.evidence.rebuilt import built, described, perturbed_as_said, refusing, require_fitting
from sim.geometry.mjcf import columns, solid_geoms
from sim.simulation.recorder import COMMANDS_PER_UNIT
from sim.simulation.run import FRAME_RATE_HZ

AT_LOCATION_M = 0.045
"""Greatest horizontal distance of an object at a location from the centre of a slot."""

CONTACT_DISTANCE_M = 0.002
"""Shapes nearer than this are in contact: distances of resting objects vary by micrometres."""

UPRIGHT_TILT_RAD = np.radians(20)
"""Greatest tilt of an object that stands."""

AT_HEIGHT_M = 0.008
"""Greatest vertical distance from a location's surface to the underside of an object there, m: an object that leans on
something may touch the surface and yet be higher."""

NOISE_FACTOR = 2
"""Greatest error of a measured position, in multiples of `RecordedWorld.noise`: as a measurement averages ten
observations, this is six of its standard deviations, and four of those of the distance between two objects."""

HOLD_FORCE_N = 0.5
"""Least contact force of each pad on a held object: about the weight of a default cube."""

TIPS_M = 0.008
"""Distance of an object from the middle of the pads, m, beyond which only the tips of the pads hold it."""

PRESS_MEMORY_FRAMES = round(0.2 * FRAME_RATE_HZ)
"""Number of frames that a contact force counts for: simulated contacts flicker."""


class RecordedWorld:
    """The world of a log, at one frame at a time.

    Attributes:
        scenario: the given one, or else read from the log.
        model: the scenario's manipulation model.
        actions: the run's actions, parsed by the model.
        mujoco: the scene's MuJoCo model.
        robot: the scene's robot.
        scene: the scene, perturbed as the log's setting says.
        start: (nq,) positions at which the run begins, drawn with its seed.
        noise: standard deviation of an observed coordinate, m.
        bias: (3,) constant error of every observed position, drawn with the seed, m.
        objects: names of the scenario's objects, and of those that faults added.
        grips: (T,) commands of the gripper.
        pad_forces: (T, pads) contact force on each of the gripper's pads, N; 0 where it was not simulated again.

    Raises:
        LogError: (on construction) the scenario in the log cannot be read or built, or its frames do not fit into it.
    """

    def __init__(self, log: Log, scenario: Scenario | None = None) -> None:
        """Build the scene of a scenario; None for the one that the log describes."""
        about = log.about
        self._log = log
        self.scenario = scenario or described(about)
        self.scene, self.start, self.noise, self.bias = perturbed_as_said(built(self.scenario, about), about)
        self.model, self.mujoco, self.robot = self.scene.model, self.scene.mujoco, self.scene.robot
        self.objects = (*(obj.name for obj in self.model.objects), *self.scene.spares)
        require_fitting(log, self.scene)
        with refusing("the log is broken"):
            self.actions = tuple(self.model.action(action.action) for action in about.actions)
        self._data, self._frame = mujoco.MjData(self.mujoco), 0
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

    def label(self, said: Label | None = None) -> Label:
        """Return the propositions, marks aside, that hold in the frame that is shown.

        What a noisy observation leaves open is taken from `said`, the label in the log, if it is given.
        """
        held = self.held()
        # An observation need not show an object in the hand that hangs at the tips of the pads.
        if held and said is not None and holding(held) not in said and self._is_at_tips(held):
            held = None
        resting = {at(obj, place) for obj, place in self.resting(held, said).items()}
        return frozenset(resting | ({holding(held)} if held else set()))

    def held(self) -> str | None:
        """Return the object in contact with all pads, if they pressed within the last `PRESS_MEMORY_FRAMES`, or None.

        Only frames in which the gripper was commanded to hold count.
        """
        recent = slice(max(0, self._frame - PRESS_MEMORY_FRAMES), self._frame + 1)
        pressed = self.pad_forces[recent].min(axis=1) > HOLD_FORCE_N
        if not any(pressed & [self.robot.gripper.holds(command) for command in self.grips[recent]]):
            return None
        return next((obj for obj in self.objects if all(self._touches(obj, pad) for pad in self._pads)), None)

    def _is_at_tips(self, obj: str) -> bool:
        """Return whether the middle of the pads is so far from an object that only their tips can hold it."""
        tool, body = self._data.site(self.robot.tool), self._data.body(obj)
        middle = body.xmat.reshape(3, 3).T @ (tool.xpos - body.xpos)
        return self.scene.shapes[obj].distance(middle) > TIPS_M

    def fallen(self) -> set[str]:
        """Return the objects that are below the table top."""
        return {obj for obj in self.objects if self._data.body(obj).xpos[2] <= 0}

    def resting(self, held: str | None, said: Label | None = None) -> dict[str, str]:
        """Return the location of every object that rests at one, as the camera shows it, except the held one.

        An object rests at a location if it stands near a slot, level with the surface. At a location on others, it
        stands near the middle of the objects below, level with the top of one of them. If a location has more objects
        than slots, only the nearest count. What noise leaves open is taken from `said`, as in `label`.
        """
        elsewhere = {held, *self.fallen()}
        objects = [obj for obj in self.objects if obj not in elsewhere and self._stands(obj)]
        found: dict[str, tuple[float, str]] = {}
        for place in sorted(self.model.locations, key=lambda place: self._slots(place)[0][2]):
            carriers = {where: obj for obj, (_, where) in found.items() if where in place.on}
            for obj in objects:
                doubt = 0 if said is None else 1 if at(obj, place.name) in said else -1
                if self._rests(obj, place, carriers, slack=doubt * NOISE_FACTOR * self.noise):
                    off = min(np.hypot(*(slot - self._observed(obj))[:2]) for slot in self._slots(place))
                    found[obj] = min(found.get(obj, (np.inf, "")), (float(off), place.name))
        free, kept = {place.name: place.capacity for place in self.model.locations}, dict[str, str]()
        for obj, (_, name) in sorted(found.items(), key=lambda item: item[1]):
            if free[name]:
                free[name] -= 1
                kept[obj] = name
        return kept

    def _rests(self, obj: str, place: Location, carriers: Mapping[str, str], *, slack: float) -> bool:
        """Return whether a standing object is at a location, given the objects at the locations below that."""
        position, slots = self._observed(obj), self._slots(place)
        middles, floors = slots, [slots[0][2]]
        if place.on:
            tops = {where: self._observed(below) for where, below in carriers.items() if below != obj}
            below = [tops[where] if where in tops else self.scene.slots[where][0].position for where in place.on]
            middles = [np.mean(below, axis=0)]
            floors = [tops[where][2] + self._half_height(carriers[where]) for where in tops]
        near = any(np.hypot(*(middle - position)[:2]) < AT_LOCATION_M + slack for middle in middles)
        underside = position[2] - self._half_height(obj)
        return near and any(abs(underside - floor) < AT_HEIGHT_M + slack for floor in floors)

    def _slots(self, place: Location) -> Sequence[np.ndarray]:
        """Return the (3,) positions of a location's slots, m."""
        return [slot.position for slot in self.scene.slots[place.name]]

    def _observed(self, obj: str) -> np.ndarray:
        """Return the (3,) position of an object with the camera's constant error, m."""
        return np.asarray(self._data.body(obj).xpos + self.bias)

    def _half_height(self, obj: str) -> float:
        return float(self.scene.shapes[obj].half[2])

    def _stands(self, obj: str) -> bool:
        """Return whether an object stands upright, up to its shape's symmetry: a cube may stand on any face."""
        rotation = self.scene.shapes[obj].most_upright(self._data.body(obj).xmat.reshape(3, 3))
        return bool(rotation[2, 2] > np.cos(UPRIGHT_TILT_RAD))

    def _touches(self, obj: str, other: int) -> bool:
        return any(touching(self._data, geom, other) for geom in solid_geoms(self.mujoco, obj).tolist())


def touching(data: mujoco.MjData, geom: int, other: int) -> bool:
    """Return whether two geoms are nearer than `CONTACT_DISTANCE_M`."""
    far = mujoco.mj_geomDistance(data.model, data, geom, other, 2 * CONTACT_DISTANCE_M, None)
    return bool(far < CONTACT_DISTANCE_M)
