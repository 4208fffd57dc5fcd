"""Kinematics of an arm: differential inverse kinematics by mink, for single goals and along paths of the tool."""

from __future__ import annotations

import mink
import mujoco
import numpy as np

from sim.errors import SimulationError
from sim.motion.timing import begun_late, timed
from sim.motion.trajectory import CONTROL_PERIOD_S, ToolPath, ToolPose, arch, wrap
from sim.robots.robot import Robot

PATH_PERIOD_S = 0.02
"""Time between two points of a path for which the joints are solved, s; a smooth curve joins them."""

POSITION_TOLERANCE_M, ANGLE_TOLERANCE_RAD = 0.001, 0.005
"""Greatest errors of the tool at the end of a movement."""

FRAME_COST, TURN_COST, POSTURE_COST = 10.0, 3.0, 2e-2
"""Weights of position (per m), orientation and posture (per rad): the posture decides the elbow alone."""

SATURATED_SHARE, SATURATED_PACE = 0.99, 0.7
"""A joint at this share of its greatest speed lags behind the tool's path, which is then followed at such a pace."""

JOINT_MARGIN_RAD = 0.01
"""Distance that references keep from the ends of the joints, rad."""

MAX_GOAL_STEPS = 60
"""Most IK steps to a goal; about 15 are used."""

MIN_VERTICAL_COMPONENT = 0.999
"""Least vertical component of the axis of a joint that turns the arm or the tool about the vertical."""

TURN_SAMPLES = 16
"""Number of configurations at which the tool's yaw is followed from the start of a movement to its goal."""


class Arm:
    """Kinematics of a robot's n joints; q is (n,), rad or m, everywhere."""

    def __init__(self, robot: Robot) -> None:
        """Compile the robot's arm."""
        self.model, self.robot = robot.kinematics(), robot
        self._configuration = mink.Configuration(self.model)
        self._frame = mink.FrameTask(robot.tool, "site", position_cost=FRAME_COST, orientation_cost=TURN_COST)
        self._posture = mink.PostureTask(self.model, cost=POSTURE_COST)
        self._limits = [
            mink.ConfigurationLimit(self.model, min_distance_from_limits=JOINT_MARGIN_RAD),
            mink.VelocityLimit(self.model, dict(zip(robot.joints, robot.velocity_limits, strict=True))),
        ]
        self._home = self.tool(robot.home)
        hinge = self.model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE
        upright = self._configuration.data.xaxis[:, 2]
        self._turns = np.where(hinge & (np.abs(upright) > MIN_VERTICAL_COMPONENT), np.sign(upright), 0.0)

    def tool(self, q: np.ndarray) -> ToolPose:
        """Return the tool's pose at a configuration."""
        self._configuration.update(q)
        site = self._configuration.data.site(self.robot.tool)
        line = site.xmat.reshape(3, 3)[:, 1]
        return ToolPose(site.xpos.copy(), float(np.arctan2(line[1], line[0])))

    def reach(self, position: np.ndarray, yaws: list[float]) -> tuple[np.ndarray, float]:
        """Return a configuration that brings the tool to a position, and the yaw it takes there.

        It depends on the goal alone: the search starts from home turned towards the goal and stays in that vertical
        plane, so the elbow cannot wander from goal to goal. Of several yaws the one whose seed has the last joint
        nearest to the middle of its range is tried first.

        Args:
            position: (3,) m.
            yaws: those that would do, rad.

        Raises:
            SimulationError: no configuration does.
        """
        seeds = [self._seed(position, yaw) for yaw in yaws]
        middle = self.model.jnt_range[-1].mean()
        for i in sorted(range(len(yaws)), key=lambda i: abs(seeds[i][-1] - middle)):
            self._configuration.update(seeds[i])
            self._posture.set_target(seeds[i])
            self._frame.set_target(_transform(position, yaws[i]))
            for _ in range(MAX_GOAL_STEPS):
                velocity = self._solve(1.0)
                self._configuration.integrate_inplace(velocity, 1.0)
                if np.abs(velocity).max() < 1e-4:
                    break
            if self._arrived():
                return self._configuration.q, yaws[i]
        at = ", ".join(f"{x:.3f}" for x in position)
        raise SimulationError(f"the arm cannot point down at ({at}) m within the limits of its joints")

    def _seed(self, position: np.ndarray, yaw: float) -> np.ndarray:
        """Return home with the first joint turned towards a position and the last to a yaw, if they are vertical."""
        q = self.robot.home.copy()
        first, last = self._turns[[0, -1]]
        turn = _bearing(position) - _bearing(self._home.position)
        q[0] += first * turn
        if last and len(q) > 1:
            middle = self.model.jnt_range[-1].mean()
            q[-1] = middle + wrap(q[-1] + last * (yaw - self._home.yaw - abs(first) * turn) - middle)
        return q

    def move(
        self,
        q: np.ndarray,
        goal: np.ndarray,
        position: np.ndarray,
        yaw: float,
        *,
        height: float | None = None,
        drawn_in: float = 0.0,
        seconds: float = 0.0,
        ending: np.ndarray | None = None,
    ) -> np.ndarray:
        """Return the joint references of an arching movement, slowed until the joints' limits allow it.

        Args:
            q: (n,) where it starts.
            goal: (n,) near where it ends, from `reach`: it decides how the elbow and the tool turn.
            position: (3,) where the tool ends, m.
            yaw: of the tool there, rad.
            height: at which the tool passes, m; None for that of the higher end (see `arch`).
            drawn_in: how much nearer to the base it goes midway, m.
            seconds: least duration, s.
            ending: (M, n) what is left of the movement before, relative to q, rad; both together keep to the limits.

        Returns:
            (N, n) rad or m, every `CONTROL_PERIOD_S`, without that ending.

        Raises:
            SimulationError: the tool would not arrive within `POSITION_TOLERANCE_M` and `ANGLE_TOLERANCE_RAD`.
        """
        start = self.tool(q)
        turn = self._turn(q, goal)
        turn += wrap(yaw - start.yaw - turn)
        pace = 1.0
        for _ in range(5):
            path = arch(
                start,
                ToolPose(position, yaw),
                turn,
                height=height,
                drawn_in=drawn_in,
                nearest=self.robot.nearest_m,
                pace=pace,
            )
            knots, points = self._follow(q, goal, path)
            speeds = np.abs(np.diff(points, axis=0)) / np.diff(knots)[:, None]
            if (speeds < SATURATED_SHARE * self.robot.velocity_limits).all():
                break
            pace *= SATURATED_PACE
        if not self._arrived():
            at = ", ".join(f"{x:.3f}" for x in position)
            raise SimulationError(f"the arm cannot keep to its path to ({at}) m within the limits of its joints")
        references = timed(self.robot, knots, points, seconds=seconds)
        return references if ending is None else begun_late(self.robot, references, q, ending)

    def _turn(self, q: np.ndarray, goal: np.ndarray) -> float:
        """Return the tool's turn about z as the joints go straight from one configuration to another, rad."""
        yaws = np.unwrap([self.tool(q + share * (goal - q)).yaw for share in np.linspace(0, 1, TURN_SAMPLES)])
        return float(yaws[-1] - yaws[0])

    def _follow(self, q: np.ndarray, goal: np.ndarray, path: ToolPath) -> tuple[np.ndarray, np.ndarray]:
        """Return (K,) times, s, and the (K, n) configurations, rad, in which the tool then is on its path."""
        self._configuration.update(q)
        every = round(PATH_PERIOD_S / CONTROL_PERIOD_S)
        chosen = np.arange(len(path.yaws))[::-1][::every][::-1]
        knots = np.array([0.0, *(chosen + 1) * CONTROL_PERIOD_S])
        points = np.empty((len(knots), len(q)))
        points[0] = q
        for k, i in enumerate(chosen, 1):
            share = path.progress[i]
            self._frame.set_target(_transform(path.positions[i], path.yaws[i]))
            self._posture.set_target(q + share * (goal - q))
            period = knots[k] - knots[k - 1]
            self._configuration.integrate_inplace(self._solve(period), period)
            points[k] = self._configuration.data.qpos
        return knots, points

    def _arrived(self) -> bool:
        error = self._frame.compute_error(self._configuration)
        shift, turn = np.linalg.norm(error[:3]), np.linalg.norm(error[3:])
        return bool(shift < POSITION_TOLERANCE_M and turn < ANGLE_TOLERANCE_RAD)

    def _solve(self, period: float) -> np.ndarray:
        """Return the joint velocities, rad/s, that bring the tool towards its target within the limits.

        The limits hardly ever bind, and the least-squares problem without them costs a third: it comes first.
        """
        q = self._configuration.data.qpos
        jacobian, error, damping = self._frame.compute_qp_residual(self._configuration)
        normal = jacobian.T @ jacobian + (damping + POSTURE_COST**2) * np.eye(len(q))
        step = np.linalg.solve(normal, jacobian.T @ error + POSTURE_COST**2 * (self._posture.target_q - q))
        low, high = self.model.jnt_range.T
        q = q + step
        if (
            (np.abs(step) <= period * self.robot.velocity_limits).all()
            and (q > low + JOINT_MARGIN_RAD).all()
            and (q < high - JOINT_MARGIN_RAD).all()
        ):
            return step / period
        tasks = [self._frame, self._posture]
        try:
            return mink.solve_ik(self._configuration, tasks, period, "daqp", limits=self._limits)
        except mink.NoSolutionFound:
            raise SimulationError("the arm cannot move on within the limits of its joints") from None


def _transform(position: np.ndarray, yaw: float) -> mink.SE3:
    half = (yaw + np.pi / 2) / 2
    return mink.SE3(wxyz_xyz=np.array([0.0, np.cos(half), np.sin(half), 0.0, *position]))


def _bearing(position: np.ndarray) -> float:
    return float(np.arctan2(position[1], position[0]))
