"""The robots that can be chosen by name: every one that a module of `sim.robots.arms` defines."""

import importlib
import pkgutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from prefplan.errors import check_known, choices
from prefplan.models.manipulation.surroundings import RobotSetup
from sim.errors import RobotError, SimulationError
from sim.robots import arms
from sim.robots.import_mjcf import ImportedArm
from sim.robots.robot import Robot
from sim.robots.user_robot import check_robot, user_robot

DEFAULT = RobotSetup.name
"""The robot of a scenario that names none."""


def _defined() -> Iterator[Robot | ImportedArm]:
    """Yield every robot of `sim.robots.arms`."""
    for module in pkgutil.iter_modules(arms.__path__, f"{arms.__name__}."):
        for value in vars(importlib.import_module(module.name)).values():
            if isinstance(value, (Robot, ImportedArm)):
                yield value


ROBOTS = {robot.name: robot for robot in _defined()}


def robot_named(name: str) -> Robot:
    """Return one of `ROBOTS`; raise `RobotError` if it is unknown, or cannot be loaded."""
    if name not in ROBOTS:
        raise RobotError(f"unknown robot {name!r} {choices(name, ROBOTS)}")
    found = ROBOTS[name]
    if isinstance(found, Robot):
        return found
    try:
        return found.robot()
    except (RobotError, ValueError) as error:
        reason = " ".join(str(error).split())
        raise RobotError(
            f"the robot `{name}` is not available here: {reason}; the robot `{DEFAULT}` needs no download"
        ) from None


def robot_for(setup: RobotSetup, robot: Robot | str | None = None) -> Robot:
    """Return the robot that a scenario sets up, or `robot` (a robot or a name) in its place.

    Raises:
        RobotError: `robot` is unknown, or the robot cannot be loaded.
        SimulationError: the scenario's robot is unknown or its pose impossible, or its MJCF does not fit its table; the
            message begins with the key.
    """
    check_robot(setup)
    if robot is None and setup.mjcf is not None:
        robot = user_robot(setup)
        if robot.name in ROBOTS:  # logs tell robots apart by their names
            robot = replace(robot, name=Path(setup.mjcf).name)
    elif robot is None:
        check_known("robot", "name", setup.name, ROBOTS, SimulationError)
    if not isinstance(robot, Robot):
        robot = robot_named(robot or setup.name)
    position = robot.position if setup.position is None else np.array(setup.position)
    return replace(robot, position=position, yaw=float(np.radians(setup.yaw)))
