"""The robots that can be chosen by name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from prefplan.errors import check_known, choices
from prefplan.models.manipulation.surroundings import RobotSetup
from sim.errors import RobotError, SimulationError
from sim.robots.fetch import FETCH
from sim.robots.menagerie.gen3 import GEN3
from sim.robots.menagerie.panda import MENAGERIE_PANDA
from sim.robots.menagerie.ur5e import UR5E
from sim.robots.menagerie.xarm7 import XARM7
from sim.robots.own import own_robot
from sim.robots.panda import PANDA
from sim.robots.panda_suction import PANDA_SUCTION
from sim.robots.robot import Robot
from sim.robots.setup import check_robot

ROBOTS = {robot.name: robot for robot in (PANDA, PANDA_SUCTION, FETCH, MENAGERIE_PANDA, UR5E, XARM7, GEN3)}

DEFAULT = RobotSetup.name
"""The robot of a scenario that names none."""

OLD_NAMES = {"default": DEFAULT}
"""Names in logs of earlier versions, and their current names."""


def robot_named(name: str) -> Robot:
    """Return one of `ROBOTS`.

    Raises:
        RobotError: it is unknown, or cannot be loaded.
    """
    name = OLD_NAMES.get(name, name)
    if name not in ROBOTS:
        raise RobotError(f"unknown robot {name!r} {choices(name, ROBOTS)}")
    return ROBOTS[name].completed()


def robot_for(setup: RobotSetup, name: str | None = None) -> Robot:
    """Return the robot that a scenario sets up, or the one called `name` in its place.

    Raises:
        RobotError: `name` is unknown, or the robot cannot be loaded.
        SimulationError: the scenario's robot is unknown, or its MJCF does not fit its table; the message begins with
            the key.
    """
    if setup.mjcf is not None and name is None:
        own = own_robot(setup)
        if own.name in ROBOTS:  # logs tell robots apart by their names
            own = replace(own, name=Path(setup.mjcf).name)
        return placed(own, setup)
    if name is None:
        check_known("robot", "name", setup.name, ROBOTS, SimulationError)
    return placed(robot_named(name or setup.name), setup)


def placed(robot: Robot, setup: RobotSetup) -> Robot:
    """Return a robot with its base where a scenario puts it; errors as in `check_robot`."""
    check_robot(setup)
    position = robot.position if setup.position is None else np.array(setup.position)
    return replace(robot, position=position, yaw=float(np.radians(setup.yaw)))
