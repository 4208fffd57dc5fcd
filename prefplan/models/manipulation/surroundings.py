"""The surroundings of a manipulation model's locations: fixtures, and the robot with its base."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path

from prefplan.errors import ModelError, check_known
from prefplan.text.names import check_names

Point = tuple[float, float, float]

FIXTURES = ("box", "shelf")
"""Kinds of fixtures: a solid box, and boards between two sides and a back."""

MAX_FIXTURE_M = 20.0
"""Largest length and coordinate of a fixture; larger ones are probably in millimetres."""


@dataclass(frozen=True)
class Fixture:
    """An obstacle, which may support locations.

    Attributes:
        name: its name.
        kind: one of `FIXTURES`.
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


GRIPPERS = ("parallel", "suction")
"""Kinds of grippers: two fingers, and a suction cup."""

MAX_OPENING_M = 0.5
"""Largest opening of a gripper; larger ones are probably in millimetres."""

OWN_KEYS = ("joints", "tool", "gripper", "home", "velocity", "torque")
"""Keys that a robot of the user's own needs."""


@dataclass(frozen=True)
class GripperSetup:
    """The gripper of a robot of the user's own.

    Attributes:
        kind: one of `GRIPPERS`.
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
    """The robot of a scene and the pose of its base.

    The keys from `mjcf` on describe a robot of the user's own.

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


def check_beside(path: str | None, where: str) -> None:
    """Raise `ModelError` for an absolute path: logs store files by their paths relative to the scenario's folder."""
    if path is not None and Path(path).is_absolute():
        raise ModelError(f"{where}: must be a path from the folder of the scenario file, not {path!r}")


def check_fixtures(fixtures: tuple[Fixture, ...], taken: Collection[str]) -> None:
    """Raise `ModelError` for fixtures that are invalid, or whose names are taken; the message begins with the key."""
    check_names([fixture.name for fixture in fixtures], where="fixtures")
    for fixture in fixtures:
        where = f"fixtures.{fixture.name}"
        if fixture.name in taken:
            raise ModelError(f"{where}: an object or a location has this name")
        check_known(f"{where}.kind", "kind", fixture.kind, FIXTURES)
        check_point(fixture.at, f"{where}.at")
        if not all(math.isfinite(length) and length > 0 for length in fixture.size):
            raise ModelError(f"{where}.size: must be positive lengths, not {list(fixture.size)}")
        for key in ("at", "size"):
            lengths = getattr(fixture, key)
            if max(map(abs, lengths)) > MAX_FIXTURE_M:
                raise ModelError(f"{where}.{key}: must be metres, at most {MAX_FIXTURE_M:g}, not {list(lengths)}")
        if not math.isfinite(fixture.yaw):
            raise ModelError(f"{where}.yaw: must be a finite number of degrees, not {fixture.yaw}")
        if fixture.rgba is not None and not all(0 <= part <= 1 for part in fixture.rgba):
            raise ModelError(f"{where}.rgba: each part must lie between 0 and 1, not {list(fixture.rgba)}")
        _check_boards(fixture, f"{where}.boards")
        _check_foot(fixture, f"{where}.at")


def _check_boards(fixture: Fixture, where: str) -> None:
    if fixture.kind != "shelf":
        if fixture.boards:
            raise ModelError(f"{where}: only a shelf has boards")
        return
    if not fixture.boards:
        raise ModelError(f"{where}: missing; a shelf has one at least, as in boards = [0.0, 0.25]")
    height = fixture.size[2]
    for board in fixture.boards:
        if not 0 <= board <= height:
            raise ModelError(f"{where}: {board:g} is not from 0 to {height:g} m, the height of the shelf")


def _check_foot(fixture: Fixture, where: str) -> None:
    """Raise `ModelError` if a fixture reaches into the table."""
    half = fixture.size[2] / 2 if fixture.kind == "box" else 0.0
    if fixture.at[2] < half - 1e-6:
        middle = "`at` is its centre, so its height is" if half else "`at` is the middle of its foot, so its height is"
        depth = half - fixture.at[2]
        raise ModelError(f"{where}: it reaches {depth:.3f} m into the table; {middle} at least {half:g}")


def check_robot(robot: RobotSetup) -> None:
    """Raise `ModelError` for an invalid pose of the base, or invalid keys of a robot of the user's own."""
    if robot.at is not None:
        check_point(robot.at, "robot.at")
        height = with_height(robot.at)[2]
        if height < 0:
            raise ModelError(f"robot.at: the base is {-height:g} m below the table top; at least 0")
    if not math.isfinite(robot.yaw):
        raise ModelError(f"robot.yaw: must be a finite number of degrees, not {robot.yaw}")
    _check_own(robot)


def _check_own(robot: RobotSetup) -> None:
    """Raise `ModelError` if the table of a robot of the user's own lacks a key or has an invalid value."""
    if robot.mjcf is None:
        for key in (*OWN_KEYS, "acceleration"):
            if getattr(robot, key):
                raise ModelError(f"robot.{key}: needs robot.mjcf, the file of a robot of one's own")
        return
    check_beside(robot.mjcf, "robot.mjcf")
    for key in OWN_KEYS:
        if not getattr(robot, key):
            raise ModelError(f"robot.{key}: missing; a robot with `mjcf` needs {', '.join(OWN_KEYS)}")
    count = len(robot.joints)
    for key in ("home", "velocity", "torque", "acceleration"):
        values = getattr(robot, key)
        if values and len(values) != count:
            raise ModelError(f"robot.{key}: must have {count} entries, one for each of robot.joints, not {len(values)}")
        if not all(math.isfinite(value) and (value > 0 or key == "home") for value in values):
            wanted = "finite numbers" if key == "home" else "positive numbers"
            raise ModelError(f"robot.{key}: must be {wanted}, not {list(values)}")
    for joint in robot.joints:
        if robot.joints.count(joint) > 1:
            raise ModelError(f"robot.joints: {joint!r} is listed twice")
    if robot.gripper is not None:
        _check_gripper(robot.gripper)


def _check_gripper(gripper: GripperSetup) -> None:
    where = "robot.gripper"
    check_known(f"{where}.kind", "kind", gripper.kind, GRIPPERS)
    if not (math.isfinite(gripper.force) and gripper.force > 0):
        raise ModelError(f"{where}.force: must be positive, N, not {gripper.force}")
    if gripper.kind == "parallel":
        if gripper.open is None:
            raise ModelError(f"{where}.open: missing; the greatest width between the fingers, m")
        if not 0 <= gripper.closed < gripper.open <= MAX_OPENING_M:
            raise ModelError(
                f"{where}: 0 <= closed < open <= {MAX_OPENING_M:g} m, not {gripper.closed:g} and {gripper.open:g}"
            )
