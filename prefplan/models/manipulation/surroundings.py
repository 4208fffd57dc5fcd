"""What stands around the locations of a manipulation model: fixtures, and the robot's base."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path

from prefplan.errors import ModelError, check_known
from prefplan.names import check_names

Point = tuple[float, float, float]

FIXTURES = ("box", "shelf")
"""Kinds of fixtures: a solid block, and boards between two sides and a back."""

MAX_FIXTURE_M = 20.0
"""Greatest length and distance from the origin of a fixture: greater ones are millimetres taken for metres."""


@dataclass(frozen=True)
class Fixture:
    """What stands in the way and carries locations.

    Attributes:
        kind: one of `FIXTURES`.
        at: (x, y, z) of a box's centre, of the middle of a shelf's foot, m.
        size: its full lengths along its own x, y and z, m.
        yaw: heading of its own x axis, degrees; a shelf is open towards it.
        boards: heights over `at` of the upper sides of a shelf's boards, m.
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
"""Greatest opening of a gripper: wider ones are millimetres taken for metres."""

OWN_KEYS = ("joints", "tool", "gripper", "home", "velocity", "torque")
"""Keys that a robot of one's own needs."""


@dataclass(frozen=True)
class GripperSetup:
    """The gripper of a robot of one's own.

    Attributes:
        kind: one of `GRIPPERS`.
        actuator: in the MJCF: a position servo that moves both fingers, or the adhesion of a cup.
        force: greatest one of each finger, or of the cup, N.
        open: greatest width between the fingers, m; needed for those.
        closed: least one, m.
    """

    kind: str
    actuator: str
    force: float
    open: float | None = None
    closed: float = 0.0


@dataclass(frozen=True)
class RobotSetup:
    """Which robot works in a scene, and where its base stands.

    With `mjcf` it is one of one's own.

    Attributes:
        name: of a robot that the simulation knows, or of one's own.
        at: (x, y) or (x, y, z) of its base, m; the table top is at z = 0, and a pedestal carries a base above it. None
            for where the robot usually stands: most at the origin.
        yaw: heading of its base, degrees; 0 looks along x.
        mjcf: the MJCF of a robot of one's own, a path relative to the scenario file.
        joints: of its arm, n in number, from base to wrist.
        tool: site between the fingers or at the lip of the cup: z out of the hand, the fingers close along y.
        gripper: its hand.
        home: (n,) where it starts, the tool pointing down in front of the base, rad or m.
        velocity: (n,) limits, rad/s or m/s.
        torque: (n,) limits, N m or N.
        acceleration: (n,) limits, rad/s^2 or m/s^2; none if they are not known.
        folder: that `mjcf` is relative to.
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
        """(x, y, z) of its base, m; None for where it usually stands."""
        return None if self.at is None else with_height(self.at)


def with_height(at: tuple[float, ...]) -> Point:
    """Return a point of two or three coordinates as (x, y, z), m; without a height it is on the table top."""
    x, y, *height = at
    return (x, y, height[0] if height else 0.0)


def check_point(at: tuple[float, ...], where: str) -> None:
    """Raise `ModelError` unless a point has two or three finite coordinates; the message begins with its key."""
    if len(at) not in (2, 3):
        raise ModelError(f"{where}: must be [x, y] or [x, y, height], not {list(at)}")
    if not all(map(math.isfinite, at)):
        raise ModelError(f"{where}: must be finite numbers, not {list(at)}")


def check_beside(path: str | None, where: str) -> None:
    """Raise `ModelError` for a path that does not start from the scenario's folder: logs keep files by such paths."""
    if path is not None and Path(path).is_absolute():
        raise ModelError(f"{where}: must be a path from the folder of the scenario file, not {path!r}")


def check_fixtures(fixtures: tuple[Fixture, ...], taken: Collection[str]) -> None:
    """Raise `ModelError` for fixtures that make no sense, or whose names are taken; the message begins with its key."""
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
    """Raise `ModelError` for a base that cannot stand where it is put."""
    if robot.at is not None:
        check_point(robot.at, "robot.at")
        height = with_height(robot.at)[2]
        if height < 0:
            raise ModelError(f"robot.at: the base is {-height:g} m below the table top; at least 0")
    if not math.isfinite(robot.yaw):
        raise ModelError(f"robot.yaw: must be a finite number of degrees, not {robot.yaw}")
    _check_own(robot)


def _check_own(robot: RobotSetup) -> None:
    """Raise `ModelError` if the table of a robot of one's own lacks a key, or has a value that makes no sense."""
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
            raise ModelError(f"robot.joints: {joint!r} is there twice")
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
