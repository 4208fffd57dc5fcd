"""The robots that can be chosen by name."""

from __future__ import annotations

from prefplan.errors import choices
from sim.errors import RobotError
from sim.robots.menagerie import MENAGERIE_PANDA
from sim.robots.panda import PANDA
from sim.robots.robot import Robot

ROBOTS = {robot.name: robot for robot in (PANDA, MENAGERIE_PANDA)}


def robot_named(name: str) -> Robot:
    """Return one of `ROBOTS`.

    Raises:
        RobotError: it is unknown.
    """
    if name not in ROBOTS:
        raise RobotError(f"unknown robot {name!r} {choices(name, ROBOTS)}")
    return ROBOTS[name]
