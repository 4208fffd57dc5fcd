"""Kinematics of an arm: configurations for goals of its tool, and movements along paths of the tool."""

import itertools

import numpy as np

from sim.errors import SimulationError, in_metres
from sim.motion.dynamics import InverseDynamics
from sim.motion.ik import InverseKinematics
from sim.motion.joint_trajectory import JointTrajectory
from sim.motion.timing import MotionLimits, begun_late, timed
from sim.motion.trajectory import (
    ACCELERATION_M_S2,
    CONTROL_PERIOD_S,
    MIN_DURATION_S,
    SPEED_M_S,
    TURN_ACCELERATION_RAD_S2,
    TURN_SPEED_RAD_S,
    ToolPath,
    ToolPose,
    duration,
    smooth_step,
    transfer_path,
    wrap,
)
from sim.robots.robot import Robot

MAX_SLOWDOWN = 2.5
"""Greatest duration along a path of the tool, as a multiple of that at its usual speed. Where the arm needs longer, its
joints jump from one point of the path to the next, and the whole movement would be as slow as its greatest jump."""

MAX_STRAY_M = 0.015
"""Greatest distance of the tool from a straight path that the joints cannot follow, m.

Near the base, where the elbow has swung aside, the joints move on a curve to the goal instead: when the tool is lowered
by 12 cm, it strays by 3 mm, and by 12 mm if the elbow swings on the way. The curve is checked for collisions."""

MAX_TILTING_RAD = np.radians(10)
"""Greatest angle between the tool's z axes at the ends of a path at which the hand counts as not tilting, rad."""


class Arm(InverseKinematics):
    """Kinematics of a robot's n joints, and movements of its tool; q is (n,), rad or m, everywhere."""

    def __init__(self, robot: Robot) -> None:
        """Compile the robot's arm."""
        super().__init__(robot)
        motors = [self.model.actuator(name).id for name in robot.joints]
        self._stiffness, self._gains = -self.model.actuator_biasprm[motors, 1:3].T
        self._damping = np.diag(self.model.opt.timestep * self._gains)
        self._dynamics = InverseDynamics(self.model)

    def limits(self, *ends: np.ndarray, load: float = 0.0) -> MotionLimits:
        """Return the limits of a movement between (n,) configurations with a load at the tool, kg."""
        inertias = np.array([self._dynamics.inertia(q, load=load) for q in ends])
        return MotionLimits(self.robot, inertias, self._damping, self._dynamics, load)

    def lag(self, q: np.ndarray, references: np.ndarray, *, load: float) -> np.ndarray:
        """Return by how much, (N, n) rad, the joints will lag behind references, as their position actuators yield.

        The movement has (N, n) references, one per control period, rad, from rest at q; the load at the tool is in kg.
        """
        rows = np.vstack([q, q, references])
        velocities = np.diff(rows, axis=0) / CONTROL_PERIOD_S
        accelerations = np.diff(velocities, axis=0) / CONTROL_PERIOD_S
        _, torques = self._dynamics.torques(references, velocities[1:], accelerations, load=load)
        yielding, lags, late = torques / self._stiffness, np.empty(references.shape), np.zeros(len(q))
        share = 1 - np.exp(-CONTROL_PERIOD_S * self._stiffness / self._gains)
        for k, row in enumerate(yielding):
            lags[k] = late = late + share * (row - late)
        return lags

    def move(
        self,
        q: np.ndarray,
        goal: np.ndarray,
        pose: ToolPose,
        *,
        height: float | None = None,
        drawn_in: float = 0.0,
        seconds: float = 0.0,
        ending: np.ndarray | None = None,
        load: float = 0.0,
    ) -> JointTrajectory:
        """Return the movement along a `transfer_path`, slowed until the joints' limits allow it.

        If the hand tilts on the way, the joints move on a curve to the goal instead (`_curve`): along a path of the
        tool, they might have to reverse.

        Args:
            q: (n,) start.
            goal: (n,) configuration near the end, from `reach`: it determines how the elbow and the tool turn.
            pose: goal of the tool.
            height: height at which the tool passes, m; None for that of the higher end, or midway if the hand tilts.
            drawn_in: how much nearer to the base the tool passes midway, m.
            seconds: least duration, s.
            ending: (M, n) rest of the previous movement, relative to q, rad; the sum of the two keeps the limits.
            load: load at the tool, kg.

        Returns:
            The movement, without `ending`.

        Raises:
            SimulationError: along its path, the tool would miss the goal by `POSITION_TOLERANCE_M` or
                `ANGLE_TOLERANCE_RAD` or more, or take longer than `MAX_SLOWDOWN` allows; and on the curve, it would
                stray farther than `MAX_STRAY_M`.
        """
        limits, start = self.limits(q, goal, load=load), self.tool(q)
        if start.rotation[:, 2] @ pose.rotation[:, 2] < np.cos(MAX_TILTING_RAD):
            movement = timed(limits, *self._curve(q, goal, height), seconds=seconds)
        else:
            turn = self._turn(q, goal)
            turn += wrap(pose.yaw - start.yaw - turn)
            straight = height is None and not pose.points_down
            path = transfer_path(self.robot, start, pose, turn, height=height, drawn_in=drawn_in, straight=straight)
            movement = self._on_path(limits, q, goal, path, seconds=seconds, height=height)
        return movement if ending is None else begun_late(limits, movement, q, ending)

    def _on_path(
        self,
        limits: MotionLimits,
        q: np.ndarray,
        goal: np.ndarray,
        path: ToolPath,
        *,
        seconds: float,
        height: float | None,
    ) -> JointTrajectory:
        """Return the movement along a path if the arm can follow it and no joint jumps, else on a curve (`_curve`)."""
        knots, points = self._follow(q, goal, path)
        fault = "the arm cannot keep to its path to {} within the limits of its joints"
        if self._arrived():
            movement = timed(limits, knots, points, seconds=seconds)
            if movement.seconds <= MAX_SLOWDOWN * max(knots[-1], seconds):
                return movement
            fault = "the arm's joints would jump on its path to {}"
        knots, points = self._curve(q, goal, height)
        if self._stray(points) > MAX_STRAY_M:
            raise SimulationError(fault.format(in_metres(path.positions[-1])))
        return timed(limits, knots, points, seconds=seconds)

    def _stray(self, points: np.ndarray) -> float:
        """Return how far the tool leaves the straight line between its ends in (K, n) configurations, m."""
        off = np.array([self.tool(q).position for q in points]) - self.tool(points[0]).position
        along = off[-1] / max(float(np.linalg.norm(off[-1])), 1e-9)
        return float(np.linalg.norm(off - np.outer(off @ along, along), axis=1).max())

    def _curve(self, q: np.ndarray, goal: np.ndarray, height: float | None) -> tuple[np.ndarray, np.ndarray]:
        """Return (K,) times, s, and (K, n) configurations, rad, from q to goal at the tool's usual speed.

        They lie on a parabola. In its middle, the tool is midway between its positions at the ends or, if given, at a
        `height`, m. If the tool is higher there anyway, or the arm does not reach this middle, they lie on a straight
        line. A joint that would leave its range stays nearer to the straight line.
        """
        shares = np.linspace(0.0, 1.0, 17)
        middle = (q + goal) / 2
        there = self.tool(middle)
        if height is None:
            shift = (self.tool(q).position + self.tool(goal).position) / 2 - there.position
        else:
            shift = np.array([0.0, 0.0, max(0.0, height - there.position[2])])
        bent = self.nearby(there.shifted(shift), middle) if shift.any() else None
        bulge = np.zeros(len(q)) if bent is None else bent - middle
        gone = smooth_step(shares)[:, None]
        points, arch = q + gone * (goal - q), 4 * gone * (1 - gone) * bulge
        low, high = np.minimum(self._low, np.minimum(q, goal)), np.maximum(self._high, np.maximum(q, goal))
        space = np.where(arch > 0, high - points, points - low) / np.maximum(np.abs(arch), 1e-9)
        points += np.minimum(space[1:-1].min(axis=0), 1.0) * arch
        positions = [self.tool(point).position for point in points]
        length = float(np.linalg.norm(np.diff(positions, axis=0), axis=1).sum())
        turn = float(np.abs(np.diff(points, axis=0)).sum(axis=0).max())
        seconds = max(
            duration(length, SPEED_M_S, ACCELERATION_M_S2),
            duration(turn, TURN_SPEED_RAD_S, TURN_ACCELERATION_RAD_S2),
            MIN_DURATION_S,
        )
        knots = shares * CONTROL_PERIOD_S * np.ceil(seconds / CONTROL_PERIOD_S)
        return knots, points

    def _turn(self, q: np.ndarray, goal: np.ndarray) -> float:
        """Return the tool's turn about z on the straight line in joint space from q to goal, rad."""
        samples = 2 + int(np.abs(goal - q).sum())  # joints turn by at most 1 rad from one to the next
        yaws = [self.tool(q + share * (goal - q)).yaw for share in np.linspace(0, 1, samples)]
        return sum(wrap(after - before) for before, after in itertools.pairwise(yaws))

    def _follow(self, q: np.ndarray, goal: np.ndarray, path: ToolPath) -> tuple[np.ndarray, np.ndarray]:
        """Return (K,) times, s, and (K, n) configurations, rad, that bring the tool to its path at these times."""
        points, shares = [q], smooth_step(path.times / path.times[-1])
        self._configuration.update(q)
        for position, rotation, share in zip(path.positions, path.rotations, shares, strict=True):
            self._aim(position, rotation, q + share * (goal - q))
            points.append(points[-1] + self._step())
            self._configuration.update(points[-1])
        return np.append(0.0, path.times), np.array(points)
