"""Motions of the arm: straight and arching tool paths, turned into joint references by differential IK."""

from __future__ import annotations

from dataclasses import dataclass

import mink
import numpy as np

from sim.errors import SimulationError
from sim.robots.catalogue import arm_spec
from sim.robots.panda import HOME, TCP, VELOCITY_LIMITS
from sim.world.places import NEAREST

CONTROL_PERIOD = 0.01
"""Time between two joint references, s."""

SPEED, ACCELERATION = 0.60, 2.5
"""Of the tool at most, m/s and m/s^2: a loaded block stays far from slipping (15 N hold 0.55 N)."""

TURN_SPEED, TURN_ACCELERATION = 1.6, 6.0
"""Of the tool about the vertical at most, rad/s and rad/s^2: below joint 7's 2.61 rad/s."""

MIN_DURATION_S = 0.15
"""Shortest duration of a movement, s."""

HEADROOM = 0.8
"""Share of the joint speed limits a reference may use; the rest is for what the controller adds."""

PRECISION, ALIGNMENT = 0.001, 0.005
"""How near to its goal a movement must end, m and rad."""

FRAME_COST, TURN_COST, POSTURE_COST = 10.0, 3.0, 2e-2
"""Weights of position (per m), orientation and posture (per rad): the posture decides the elbow alone."""

JOINT_MARGIN_RAD = 0.01
"""Distance that references keep from the ends of the joints, rad."""

MAX_GOAL_STEPS = 60
"""Most IK steps to a goal; about 15 are used."""

_FASTEST = 1.875
_HARDEST = 10 / np.sqrt(3)
"""Peak speed and acceleration of the smooth step below, in lengths per duration (squared)."""


@dataclass(frozen=True)
class ToolPose:
    """The hand pointing straight down.

    Attributes:
        position: (3,) of the point between the pads, m.
        yaw: heading about z of the line along which the fingers close, rad.
    """

    position: np.ndarray
    yaw: float


@dataclass(frozen=True)
class ToolPath:
    """A movement of the hand, sampled every `CONTROL_PERIOD`; the last sample is the goal.

    Attributes:
        positions: (N, 3) m.
        yaws: (N,) rad, continuous.
        progress: (N,) share of the whole done, 0 .. 1.
    """

    positions: np.ndarray
    yaws: np.ndarray
    progress: np.ndarray


def wrap(angle: float, period: float = 2 * np.pi) -> float:
    """Return the equivalent of an angle that is nearest to zero, rad."""
    return float((angle + period / 2) % period - period / 2)


def smooth_step(u: np.ndarray) -> np.ndarray:
    """Return a step from 0 to 1 for u from 0 to 1 of least jerk: at rest, without acceleration, at both ends."""
    u = np.clip(u, 0.0, 1.0)
    return u**3 * (10 - 15 * u + 6 * u**2)


def duration(length: float, speed: float, acceleration: float) -> float:
    """Return how long a smooth step of a length takes within a speed and an acceleration, s."""
    return float(max(_FASTEST * length / speed, np.sqrt(_HARDEST * length / acceleration)))


def arch(
    start: ToolPose,
    goal: ToolPose,
    turn: float,
    *,
    height: float | None = None,
    drawn_in: float = 0.0,
    pace: float = 1.0,
) -> ToolPath:
    """Return a path that raises the tool, carries it over along an arc about the robot's base and lowers it.

    The parts run into one another: the tool is within a fifth of the full height when it starts to the side,
    and almost above the goal before it comes down. Rising and lowering alone are straight.

    Args:
        start: where it is.
        goal: where it shall be.
        turn: change of the yaw along the path, rad; goal.yaw up to whole turns.
        height: to pass at, m, or higher for a higher goal; from above it the tool descends along the path, since high
            up the arm reaches less far. None: as high as the higher end.
        drawn_in: how much nearer to the base midway, m, but midway between the ends not nearer than `NEAREST`.
        pace: 1 for the usual speed, less for slower.
    """
    top = max(goal.position[2], start.position[2] if height is None else height)
    rise, sink, drop = max(0.0, top - start.position[2]), max(0.0, start.position[2] - top), top - goal.position[2]
    (r0, phi0), (r1, phi1) = _polar(start.position), _polar(goal.position)
    sweep = phi1 - phi0  # never wrapped: the arm turns past its front, not past the stop of its first joint
    drawn_in = max(0.0, min(drawn_in, (r0 + r1) / 2 - NEAREST))
    across = float(np.linalg.norm([r1 - r0, max(r0, r1) * sweep, sink, 2 * drawn_in]))

    times = [duration(length, SPEED, ACCELERATION) for length in (rise, across, drop)]
    times[1] = max(times[1], duration(abs(turn), TURN_SPEED, TURN_ACCELERATION))
    up, over, down = (max(t, MIN_DURATION_S) / pace if t > 1e-3 else 0.0 for t in times)
    begin_over = 0.7 * up
    begin_down = begin_over + (0.75 * over if up or over else 0.0)
    total = max(up, begin_over + over, begin_down + down)

    t = np.arange(1, max(2, int(np.ceil(total / CONTROL_PERIOD))) + 1) * CONTROL_PERIOD
    raised, carried, lowered = (
        smooth_step((t - begin) / span) if span else np.ones_like(t)
        for begin, span in ((0.0, up), (begin_over, over), (begin_down, down))
    )
    radius = r0 + (r1 - r0) * carried - drawn_in * np.sin(np.pi * carried) ** 2
    angle = phi0 + sweep * carried
    z = start.position[2] + rise * raised - sink * carried - drop * lowered
    positions = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])
    return ToolPath(positions, start.yaw + turn * carried, smooth_step(t / t[-1]))


def _polar(position: np.ndarray) -> tuple[float, float]:
    return float(np.hypot(position[0], position[1])), float(np.arctan2(position[1], position[0]))


class Arm:
    """Kinematics of the Panda's seven joints; q is (7,) rad everywhere."""

    def __init__(self, robot: str = "default") -> None:
        """Compile the arm of a robot, one of `sim.robots.catalogue.ROBOTS`."""
        self.model = arm_spec(robot).compile()
        self._configuration = mink.Configuration(self.model)
        self._frame = mink.FrameTask(TCP, "site", position_cost=FRAME_COST, orientation_cost=TURN_COST)
        self._posture = mink.PostureTask(self.model, cost=POSTURE_COST)
        names = [self.model.joint(j).name for j in range(self.model.njnt)]
        self._limits = [
            mink.ConfigurationLimit(self.model, min_distance_from_limits=JOINT_MARGIN_RAD),
            mink.VelocityLimit(self.model, dict(zip(names, VELOCITY_LIMITS, strict=True))),
        ]
        self._home_yaw = self.tool(HOME).yaw

    def tool(self, q: np.ndarray) -> ToolPose:
        """Return the tool's pose at a configuration."""
        self._configuration.update(q)
        site = self._configuration.data.site(TCP)
        line = site.xmat.reshape(3, 3)[:, 1]
        return ToolPose(site.xpos.copy(), float(np.arctan2(line[1], line[0])))

    def reach(self, position: np.ndarray, yaws: list[float]) -> tuple[np.ndarray, float]:
        """Return a configuration that brings the tool to a position, and the yaw it takes there.

        It depends on the goal alone: the search starts from the ready pose turned towards the goal and stays in
        that vertical plane, so the elbow cannot wander from goal to goal. Turning the tool moves the last joint
        alone: of several yaws the one that leaves it most margin is taken.

        Args:
            position: (3,) m.
            yaws: those that would do, rad.

        Raises:
            SimulationError: no configuration does.
        """
        seed = HOME.copy()
        seed[0] = np.arctan2(position[1], position[0])
        last = [wrap(HOME[6] + seed[0] + self._home_yaw - yaw) for yaw in yaws]
        best = int(np.argmin(np.abs(last)))
        seed[6] = last[best]
        self._configuration.update(seed)
        self._posture.set_target(seed)
        self._frame.set_target(_transform(position, yaws[best]))
        for _ in range(MAX_GOAL_STEPS):
            velocity = self._solve(1.0)
            self._configuration.integrate_inplace(velocity, 1.0)
            if np.abs(velocity).max() < 1e-4:
                break
        if not self._arrived():
            at = ", ".join(f"{x:.3f}" for x in position)
            raise SimulationError(f"the arm cannot point down at ({at}) m within the limits of its joints")
        return self._configuration.q, yaws[best]

    def move(
        self,
        q: np.ndarray,
        goal: np.ndarray,
        position: np.ndarray,
        yaw: float,
        *,
        height: float | None = None,
        drawn_in: float = 0.0,
    ) -> np.ndarray:
        """Return the joint references of an arching movement, slowed until the joints' limits allow it.

        Args:
            q: (7,) where it starts.
            goal: (7,) near where it ends, from `reach`: it decides how the elbow and the last joint turn.
            position: (3,) where the tool ends, m.
            yaw: of the tool there, rad.
            height: at which the tool passes, m; None for that of the higher end (see `arch`).
            drawn_in: how much nearer to the base it goes midway, m.

        Returns:
            (N, 7) rad, every `CONTROL_PERIOD`.

        Raises:
            SimulationError: the tool would not arrive within `PRECISION` and `ALIGNMENT`.
        """
        start = self.tool(q)
        turn = (goal[0] - q[0]) - (goal[6] - q[6])
        turn += wrap(yaw - start.yaw - turn)
        pace = 1.0
        for _ in range(5):
            path = arch(start, ToolPose(position, yaw), turn, height=height, drawn_in=drawn_in, pace=pace)
            references = self._follow(q, goal, path)
            steps = np.diff(references, axis=0, prepend=q[None])
            share = float((np.abs(steps) / CONTROL_PERIOD / VELOCITY_LIMITS).max())
            if share <= HEADROOM:
                break
            pace *= 0.95 * HEADROOM / share
        if share > HEADROOM or not self._arrived():
            at = ", ".join(f"{x:.3f}" for x in position)
            raise SimulationError(f"the arm cannot keep to its path to ({at}) m within the limits of its joints")
        return references

    def _follow(self, q: np.ndarray, goal: np.ndarray, path: ToolPath) -> np.ndarray:
        self._configuration.update(q)
        references = np.empty((len(path.yaws), 7))
        for i, (position, yaw, share) in enumerate(zip(path.positions, path.yaws, path.progress, strict=True)):
            self._frame.set_target(_transform(position, yaw))
            self._posture.set_target(q + share * (goal - q))
            self._configuration.integrate_inplace(self._solve(CONTROL_PERIOD), CONTROL_PERIOD)
            references[i] = self._configuration.data.qpos
        return references

    def _arrived(self) -> bool:
        error = self._frame.compute_error(self._configuration)
        return bool(np.linalg.norm(error[:3]) < PRECISION and np.linalg.norm(error[3:]) < ALIGNMENT)

    def _solve(self, period: float) -> np.ndarray:
        """Return the joint velocities, rad/s, that bring the tool towards its target within the limits.

        The limits hardly ever bind, and the least-squares problem without them costs a third: it comes first.
        """
        q = self._configuration.data.qpos
        jacobian, error, damping = self._frame.compute_qp_residual(self._configuration)
        normal = jacobian.T @ jacobian + (damping + POSTURE_COST**2) * np.eye(7)
        step = np.linalg.solve(normal, jacobian.T @ error + POSTURE_COST**2 * (self._posture.target_q - q))
        low, high = self.model.jnt_range.T
        q = q + step
        if (
            (np.abs(step) <= period * VELOCITY_LIMITS).all()
            and (q > low + JOINT_MARGIN_RAD).all()
            and (q < high - JOINT_MARGIN_RAD).all()
        ):
            return step / period
        tasks = [self._frame, self._posture]
        try:
            return mink.solve_ik(self._configuration, tasks, period, "daqp", limits=self._limits)
        except mink.NoSolutionFound:
            raise SimulationError("the arm has come to where the limits of its joints leave no way on") from None


def _transform(position: np.ndarray, yaw: float) -> mink.SE3:
    half = (yaw + np.pi / 2) / 2
    return mink.SE3(wxyz_xyz=np.array([0.0, np.cos(half), np.sin(half), 0.0, *position]))
