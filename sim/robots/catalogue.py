"""The robots that can be chosen by name: every one that a module of `sim.robots.arms` defines."""

from __future__ import annotations

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
    """Return one of `ROBOTS`.

    Raises:
        RobotError: it is unknown, or cannot be loaded.
    """
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


def robot_for(setup: RobotSetup, name: str | None = None) -> Robot:
    """Return the robot that a scenario sets up, or the one called `name` in its place.

    Raises:
        RobotError: `name` is unknown, or the robot cannot be loaded.
        SimulationError: the scenario's robot is unknown, or its MJCF does not fit its table; the message begins with
            the key.
    """
    if setup.mjcf is not None and name is None:
        own = user_robot(setup)
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
