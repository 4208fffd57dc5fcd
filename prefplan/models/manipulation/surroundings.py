"""Surroundings of a scenario's locations, for the simulation only: fixtures, and the robot with its base."""

import math
from dataclasses import dataclass, field
from pathlib import Path

from prefplan.errors import ModelError

Point = tuple[float, float, float]

FARTHEST_M = 1000
"""Greatest coordinate of a point in a scene, m."""


@dataclass(frozen=True)
class Fixture:
    """An obstacle, which may support locations.

    Attributes:
        name: its name.
        kind: one of `sim.world.fixtures.KINDS`.
        at: (x, y, z) of a box's centre, or of the middle of a shelf's foot, m.
        size: its full lengths along its own x, y and z, m.
        yaw: heading of its own x axis, degrees; a shelf is open in that direction.
        boards: heights above `at` of the upper sides of a shelf's boards, m.
        rgba: colour in simulation, each in 0 .. 1; None for a default.
    """

    name: str = field(metadata={"key": None})
    kind: str
    at: Point
    size: Point
    yaw: float = 0.0
    boards: tuple[float, ...] = ()
    rgba: tuple[float, float, float, float] | None = None


@dataclass(frozen=True)
class GripperSetup:
    """The gripper of a robot of the user's own.

    Attributes:
        kind: `parallel` or `suction`.
        actuator: name in the MJCF of the position servo that moves both fingers, or of the cup's adhesion actuator.
        force: greatest force of each finger, or of the cup, N.
        open: greatest width between the fingers, m; None for a suction cup.
        closed: least width, m.
    """

    kind: str
    actuator: str
    force: float
    open: float | None = None
    closed: float = 0.0


@dataclass(frozen=True)
class RobotSetup:
    """The robot of a scene and the pose of its base; the keys from `mjcf` on describe a robot of the user's own.

    Attributes:
        name: name of a robot that the simulation has, or of the user's own.
        at: (x, y) or (x, y, z) of its base, m; the table top is at z = 0, and a base above it stands on a pedestal.
            None for the robot's default, for most robots the origin.
        yaw: heading of its base, degrees; 0 looks along x.
        mjcf: path of the robot's MJCF, relative to the scenario file.
        joints: names of the arm's n joints, from base to wrist.
        tool: site between the fingers or at the lip of the cup: z points out of the hand, the fingers close along y.
        gripper: its gripper.
        home: (n,) initial joint positions, with the tool pointing down in front of the base, rad or m.
        velocity: (n,) limits, rad/s or m/s.
        torque: (n,) limits, N m or N.
        acceleration: (n,) limits, rad/s^2 or m/s^2; empty if not known.
        folder: folder that `mjcf` is relative to.
    """

    name: str = "panda"
    at: tuple[float, ...] | None = None
    yaw: float = 0.0
    mjcf: str | None = None
    joints: tuple[str, ...] = ()
    tool: str | None = None
    gripper: GripperSetup | None = None
    home: tuple[float, ...] = ()
    velocity: tuple[float, ...] = ()
    torque: tuple[float, ...] = ()
    acceleration: tuple[float, ...] = ()
    folder: Path = field(default=Path(), metadata={"key": None})

    @property
    def source(self) -> str:
        """What it is made from: the path of its MJCF, or the name of a robot that the simulation has."""
        return self.mjcf or self.name

    @property
    def position(self) -> Point | None:
        """(x, y, z) of its base, m; None for the robot's default."""
        return None if self.at is None else with_height(self.at)


def with_height(at: tuple[float, ...]) -> Point:
    """Return a point of two or three coordinates as (x, y, z), m; without a height it is on the table top."""
    x, y, *height = at
    return (x, y, height[0] if height else 0.0)


def check_point(at: tuple[float, ...], where: str) -> None:
    """Raise `ModelError` unless a point has two or three finite coordinates; the message begins with its key."""
    if len(at) not in (2, 3):
        raise ModelError(f"{where}: must be [x, y] or [x, y, height] in metres, not {list(at)}")
    if not all(map(math.isfinite, at)):
        raise ModelError(f"{where}: must be finite numbers, not {list(at)}")
    if max(map(abs, at)) > FARTHEST_M:
        raise ModelError(f"{where}: must be metres, at most {FARTHEST_M}, not {list(at)}")
