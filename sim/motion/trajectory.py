"""Paths of the tool, straight or over objects, timed by smooth steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from sim.robots.robot import Robot

CONTROL_PERIOD_S = 0.01
"""Time between two joint references, s."""

STEPS = 5
"""Number of simulation steps in a control period."""

PATH_PERIODS = 3
"""Control periods between two points of a path at which inverse kinematics is solved; a spline joins them."""

SPEED_M_S = 0.60
"""Greatest speed of the tool, m/s."""

ACCELERATION_M_S2 = 2.5
"""Greatest acceleration of the tool, m/s^2: a held block is far from slipping (15 N hold 0.55 N)."""

TURN_SPEED_RAD_S = 1.6
"""Greatest angular speed of the tool about the vertical, and of its tilt, rad/s."""

TURN_ACCELERATION_RAD_S2 = 6.0
"""Greatest angular acceleration of the tool about the vertical, and of its tilt, rad/s^2."""

MIN_DOWN_COMPONENT = 0.999
"""Least downward component of the z axis of a hand that points down."""

MIN_DURATION_S = 0.15
"""Shortest duration of a movement, s."""


@dataclass(frozen=True)
class ToolPose:
    """Pose of the hand's tool frame.

    Attributes:
        position: (3,) of the point between the pads, m.
        rotation: (3, 3) of the tool frame: z points out of the hand, the fingers close along y.
    """

    position: np.ndarray
    rotation: np.ndarray

    @classmethod
    def down(cls, position: np.ndarray, yaw: float) -> ToolPose:
        """Return the pose of a hand that points straight down, with the closing direction at a heading, rad."""
        c, s = np.cos(yaw), np.sin(yaw)
        return cls(position, np.array([[-s, c, 0.0], [c, s, 0.0], [0.0, 0.0, -1.0]]))

    @property
    def yaw(self) -> float:
        """Heading about z of the closing direction, rad."""
        return float(np.arctan2(self.rotation[1, 1], self.rotation[0, 1]))

    @property
    def points_down(self) -> bool:
        """Whether the hand points straight down."""
        return bool(self.rotation[2, 2] < -MIN_DOWN_COMPONENT)

    def shifted(self, offset: np.ndarray | list[float]) -> ToolPose:
        """Return the pose moved by (3,) m."""
        return ToolPose(self.position + offset, self.rotation)

    def leaning(self, angle: float, offset: np.ndarray) -> ToolPose:
        """Return this pose with the hand tilted about its closing direction by an angle, rad, towards a (3,) offset."""
        closing = self.rotation[:, 1]
        towards = np.sign(np.cross(closing, -self.rotation[:, 2]) @ offset)
        return ToolPose(self.position, Rotation.from_rotvec(towards * angle * closing).as_matrix() @ self.rotation)

    def ahead(self, distance: float) -> np.ndarray:
        """Return the (3,) point at a distance along the axis of the hand, m."""
        return self.position + distance * self.rotation[:, 2]

    def symmetric_poses(self) -> tuple[ToolPose, ToolPose]:
        """Return this pose and the one with the fingers exchanged, which grasps an object just as well."""
        return self, ToolPose(self.position, self.rotation * [-1.0, -1.0, 1.0])


@dataclass(frozen=True)
class ToolPath:
    """A movement of the hand, sampled every `PATH_PERIODS` up to the goal; the first interval may be shorter.

    Attributes:
        times: (N,) multiples of `CONTROL_PERIOD_S`, s.
        positions: (N, 3) m.
        rotations: (N, 3, 3) of the tool frame.
    """

    times: np.ndarray
    positions: np.ndarray
    rotations: np.ndarray


def wrap(angle: float, period: float = 2 * np.pi) -> float:
    """Return the angle equivalent up to multiples of the period that is nearest to zero, rad."""
    return float((angle + period / 2) % period - period / 2)


def smooth_step(u: np.ndarray) -> np.ndarray:
    """Return the minimum-jerk step from 0 to 1 for u from 0 to 1, with zero velocity and acceleration at both ends."""
    u = np.clip(u, 0.0, 1.0)
    return u**3 * (10 - 15 * u + 6 * u**2)


def smooth_rate(u: np.ndarray) -> np.ndarray:
    """Return the derivative of `smooth_step`."""
    u = np.clip(u, 0.0, 1.0)
    return 30 * u**2 * (1 - u) ** 2


def duration(length: float, speed: float, acceleration: float) -> float:
    """Return the least duration of a smooth step of a length within limits of speed and acceleration, s."""
    # Its peak speed is 1.875 length / duration, its peak acceleration 10 / sqrt(3) length / duration^2.
    return float(max(1.875 * length / speed, np.sqrt(10 / np.sqrt(3) * length / acceleration)))


def transfer_path(
    robot: Robot,
    start: ToolPose,
    goal: ToolPose,
    turn: float,
    *,
    height: float | None = None,
    drawn_in: float = 0.0,
    straight: bool = False,
) -> ToolPath:
    """Return a path that raises a robot's tool, moves it along an arc about the robot's base and lowers it.

    The tool has risen to within a fifth of the full height when it starts sideways, and is almost above the goal before
    it descends. Paths that only rise or descend are straight.

    Args:
        robot: the robot that moves.
        start: current pose.
        goal: goal pose.
        turn: turn of the tool about the vertical along the path, rad; the rest of the rotation to the goal is its tilt.
        height: height at which to pass, m, or higher for a higher goal; None for that of the higher end. A tool that
            starts above it descends along the path, since high up the arm's reach is smaller.
        drawn_in: how much nearer to the base the tool passes midway, m; never nearer than the arm works.
        straight: whether to rise, move sideways and descend all at once.
    """
    top = max(goal.position[2], start.position[2] if height is None else height)
    rise, sink, drop = max(0.0, top - start.position[2]), max(0.0, start.position[2] - top), top - goal.position[2]
    (r0, phi0), (r1, phi1) = (robot.polar(pose.position) for pose in (start, goal))
    sweep = phi1 - phi0  # never wrapped: the arm turns past its front, not past the stop of its first joint
    drawn_in = max(0.0, min(drawn_in, (r0 + r1) / 2 - robot.nearest_m))
    across = float(np.linalg.norm([r1 - r0, max(r0, r1) * sweep, sink, 2 * drawn_in]))

    times = [duration(length, SPEED_M_S, ACCELERATION_M_S2) for length in (rise, across, drop)]
    about_z = np.array([0.0, 0.0, turn])
    tilt = Rotation.from_matrix(Rotation.from_rotvec(-about_z).as_matrix() @ goal.rotation @ start.rotation.T)
    turned = max(abs(turn), float(tilt.magnitude()))
    times[1] = max(times[1], duration(turned, TURN_SPEED_RAD_S, TURN_ACCELERATION_RAD_S2))
    up, over, down = (max(t, MIN_DURATION_S) if t > 1e-3 else 0.0 for t in times)
    begin_over = 0.7 * up
    begin_down = begin_over + (0.75 * over if up or over else 0.0)
    if straight:
        up, over, down, begin_over, begin_down = *[max(up, over, down)] * 3, 0.0, 0.0
    total = max(up, begin_over + over, begin_down + down)

    t = np.arange(max(2, int(np.ceil(total / CONTROL_PERIOD_S))), 0, -PATH_PERIODS)[::-1] * CONTROL_PERIOD_S
    raised, carried, lowered = (
        smooth_step((t - begin) / span) if span else np.ones_like(t)
        for begin, span in ((0.0, up), (begin_over, over), (begin_down, down))
    )
    radius = r0 + (r1 - r0) * carried - drawn_in * np.sin(np.pi * carried) ** 2
    angle = robot.yaw + phi0 + sweep * carried
    over_table = robot.position[:2] + radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    z = start.position[2] + rise * raised - sink * carried - drop * lowered
    positions = np.column_stack([over_table, z])
    tilts, turns = (Rotation.from_rotvec(carried[:, None] * end) for end in (tilt.as_rotvec(), about_z))
    rotations = (turns * tilts).as_matrix() @ start.rotation
    return ToolPath(t, positions, rotations)


def spaced(path: np.ndarray, levers: np.ndarray, *, step: float) -> np.ndarray:
    """Return (M, n) configurations along (N, n) ones, from the first to the last, no more than a step, m, apart.

    The distance between two of them bounds how far a point of the robot moves: it is the sum of the joints' turns times
    their (n,) levers, m per rad or m.
    """
    moved = np.append(0.0, np.cumsum(np.abs(np.diff(path, axis=0)) @ levers))
    aheads = np.linspace(0, moved[-1], int(np.ceil(moved[-1] / step)) + 1)
    return np.column_stack([np.interp(aheads, moved, joint) for joint in path.T])
