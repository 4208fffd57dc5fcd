"""The workcell: what skills need of a running simulation, to observe, to hold, to check and to move."""

from collections.abc import Callable, Hashable, Iterable

import mujoco
import numpy as np

from sim.errors import SimulationError
from sim.motion.joint_trajectory import JointTrajectory
from sim.motion.kinematics import Arm
from sim.motion.planning import SEARCHES, MotionPlanner
from sim.motion.timing import braking_time
from sim.motion.trajectory import CONTROL_PERIOD_S, STEPS, ToolPose
from sim.perception.sensors import (
    OBSERVATION_TIMEOUT_S,
    ExactSensor,
    ObjectPose,
    ObservationTimeoutError,
    Sensor,
    mean_pose,
    object_pose,
    on_table,
)
from sim.simulation.collision import CollisionChecker
from sim.simulation.plant import CONTACT_FLICKER_S, Plant
from sim.world.scene import Scene
from sim.world.shapes import ObjectShape

WATCH_PERIOD_S = 0.05
"""Time between two checks during a movement."""

BLEND_TIME_S = 0.3
"""Longest part of a movement that is blended with the next one."""

HOLD_DISTANCE_M = 0.0085
"""Greatest distance of a held object from the point between the pads, m. The Panda's pads end 9.2 mm beyond that point:
up to this distance, a load of 3 kg, which creeps down by 1 mm/s, hangs between them. An object into which the pads'
tips press, by up to 0.3 mm, is farther away."""

OBSERVATION_ERRORS = 3
"""Tolerance of `HOLD_DISTANCE_M` for sensor noise, in standard deviations of an observed position."""


class Workcell(Plant):
    """A running simulation of a scene, with the interface that skills use.

    Attributes:
        arm: kinematics of the arm.
        levers: (n,) see `CollisionChecker.levers`.
        planner: plans paths of the arm.
        sensor: observes the objects.
    """

    def __init__(
        self,
        scene: Scene,
        data: mujoco.MjData,
        *,
        sensor: Sensor | None = None,
        seed: int = 0,
        arm: Arm | None = None,
        searches: int = SEARCHES,
    ) -> None:
        """Begin in a state in which the arm is at rest; the sensor is exact unless one is given.

        `seed` is the random seed of the searches for a path, `searches` their number. An `arm` of the same robot shares
        its cache of IK solutions.
        """
        super().__init__(scene, data)
        self.arm = arm or Arm(scene.robot)
        self._checker = CollisionChecker(scene)
        self.levers = self._checker.levers
        self.planner = MotionPlanner(scene.robot.ranges(scene.mujoco), self.levers, seed=seed, searches=searches)
        self.sensor: Sensor = sensor or ExactSensor()
        self._seen = {obj: object_pose(scene, data, obj) for obj in scene.shapes}

    @property
    def shapes(self) -> dict[str, ObjectShape]:
        """The shapes of the model's objects, and of other objects observed on the table."""
        known = {obj.name for obj in self.scene.model.objects}
        shapes = self.scene.shapes.items()
        return {obj: shape for obj, shape in shapes if obj in known or on_table(self.latest_pose(obj))}

    def latest_pose(self, obj: str) -> ObjectPose | None:
        """Return the pose of an object as observed now, or None if it is not observed."""
        pose = self.sensor.observe(self.scene, self.data, obj)
        if pose is not None:
            self._seen[obj] = pose
        return pose

    def observe(self, obj: str) -> ObjectPose:
        """Return the observed pose of an object; wait for an observation if there is none now.

        Raises:
            ObservationTimeoutError: it is not observed for `OBSERVATION_TIMEOUT_S`.
        """
        periods_left = round(OBSERVATION_TIMEOUT_S / CONTROL_PERIOD_S)
        while (pose := self.latest_pose(obj)) is None:
            if periods_left == 0:
                raise ObservationTimeoutError(f"nothing has been seen of {obj} for {OBSERVATION_TIMEOUT_S:g} s")
            periods_left -= 1
            self.step()
        return pose

    def measure(self, obj: str) -> ObjectPose:
        """Return the pose of an object at rest, averaged over the observations that its sensor needs; see `observe`."""
        return self.survey([obj])[obj]

    def survey(self, objects: Iterable[str]) -> dict[str, ObjectPose]:
        """Return the poses of objects at rest, as `measure` does."""
        samples: dict[str, list[ObjectPose]] = {obj: [self.observe(obj)] for obj in objects}
        for _ in range(self.sensor.samples - 1):
            self.step()
            for obj, poses in samples.items():
                poses.append(self.observe(obj))
        return {obj: mean_pose(poses) for obj, poses in samples.items()}

    def touch(self, obj: str | None) -> None:
        """Let the fingers touch an object that is not a load of the arm, from now on; None for no object."""
        self.contacts.handle(obj)

    def attach(self, obj: str) -> None:
        """Let an object be the load of the arm: it moves with the hand and may touch nothing but the fingers."""
        self.contacts.handle(obj, aloft=True)

    def detach(self) -> None:
        """Let the load of the arm touch what it is put on; the fingers may still touch it."""
        self.contacts.handle(self.contacts.handled)

    @property
    def attached(self) -> str | None:
        """The load of the arm, or None."""
        return self.contacts.handled if self.contacts.aloft else None

    def held(self) -> str | None:
        """Return the object that both pads press, with short losses of contact ignored, or None."""
        obj = self.contacts.handled
        if obj is None or self.lost_contact:
            return None
        return obj if self._is_between_pads(obj) else None

    def _is_between_pads(self, obj: str) -> bool:
        """Return whether an object is near enough to the pads to be held; True if it is not observed now."""
        pose = self.latest_pose(obj)
        if pose is None:
            return True
        tool = self.data.site(self.scene.robot.tool)
        distance = self.scene.shapes[obj].distance(pose.rotation.T @ (tool.xpos - pose.position))
        # `sensor.error` is that of a mean of `samples` observations; this is a single one.
        return distance < HOLD_DISTANCE_M + OBSERVATION_ERRORS * np.sqrt(self.sensor.samples) * self.sensor.error

    @property
    def in_doubt(self) -> bool:
        """Whether the pads have just lost contact with the handled object and may regain it."""
        return self.contacts.handled is not None and 0 < self.data.time - self.contacts.pressed <= CONTACT_FLICKER_S

    def follow(
        self, movement: JointTrajectory, *, within: float = 0.0, watch: Callable[[], None] = lambda: None
    ) -> None:
        """Drive the arm along a movement that begins at `reference`; it brakes if it loses its load.

        The rest of the previous movement is added, so that the arm need not stop in between (`JointTrajectory.out_of`).

        Args:
            movement: from rest to rest.
            within: return once the tool is this near to its goal, m, at most `BLEND_TIME_S` before the end: the arm
                continues to its goal as time passes. 0 to return when the arm is at rest.
            watch: called every `WATCH_PERIOD_S`; if it raises an error, the arm brakes.
        """
        self._begin(movement.out_of(self._movement.after(self._passed), self.reference))
        self.reference = movement.positions[-1]
        left = STEPS * self._periods_within(within)
        watched = STEPS * round(WATCH_PERIOD_S / CONTROL_PERIOD_S)
        carried = self.held() if self.attached else None
        while self._samples_left > left:
            self.step()
            if self._samples_left % watched:
                continue
            if carried and self._samples_left and self.held() is None:
                self.log_event("lost", object=carried)
                self.detach()
                self.brake()
            try:
                watch()
            except SimulationError:
                self.brake()
                raise

    def brake(self) -> None:
        """Stop the arm on its path, within its limits."""
        if self._samples_left:
            ending = self._movement.after(self._passed)
            periods = np.ceil(braking_time(self.scene.robot, ending.velocities[0]) / CONTROL_PERIOD_S)
            self._begin(ending.braked(int(periods) * STEPS))
            self.reference = self._movement.positions[-1]
            self.settle()

    def touches(
        self, q: np.ndarray, *, touching: str | None = None, width: float | None = None, clearance: float = 0.0
    ) -> frozenset[tuple[str, str]]:
        """Return the collisions at (n,) joint angles, rad; see `collision_checker` and `CollisionChecker.touches`."""
        return self.collision_checker(touching=touching).touches(q, width=width, clearance=clearance)

    def touches_hand(self, collision: tuple[str, str]) -> bool:
        """See `CollisionChecker.touches_hand`: no other elbow position would avoid such a collision."""
        return self._checker.touches_hand(collision)

    def hand_is_inside(self, tool: ToolPose, *, touching: str, width: float) -> bool:
        """See `CollisionChecker.hand_is_inside`: a check that can make inverse kinematics unnecessary."""
        return self.collision_checker(touching=touching).hand_is_inside(tool, width=width)

    def answers(self, obj: str) -> dict[Hashable, bool]:
        """Return a cache of answers about an object that depend only on where the other objects are.

        `KinematicCell` keeps what callers add to it; a run keeps nothing, since its observations change.
        """
        return {}

    def collision_checker(
        self, *, touching: str | None = None, held: str | None = None, width: float | None = None
    ) -> CollisionChecker:
        """Observe all objects, and return the collision checker set to their poses.

        Args:
            touching: the object that the fingers may touch.
            held: the object that moves with the hand, which may touch it.
            width: between the pads, m; None for the present one.
        """
        seen = {obj: self.latest_pose(obj) for obj in self.scene.shapes}
        carried = held is not None and seen[held] is not None
        self._checker.see(self.data, self._seen, handled=held if carried else touching, held=carried, width=width)
        return self._checker

    def _periods_within(self, distance: float) -> int:
        """Return the number of final control periods of the movement in which the tool is this near to its goal, m."""
        goal = self.arm.tool(self.reference).position
        ending = self.ending[-round(BLEND_TIME_S / CONTROL_PERIOD_S) - 1 : -1] if distance else self.ending[:0]
        for periods, offset in enumerate(ending[::-1]):
            if np.linalg.norm(self.arm.tool(self.reference + offset).position - goal) > distance:
                return periods
        return len(ending)
