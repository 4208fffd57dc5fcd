"""A user's own robot: a table in a scenario, and an MJCF beside it."""

from __future__ import annotations

from functools import cache, partial
from pathlib import Path

import mujoco
import numpy as np

from prefplan.errors import choices
from prefplan.models.manipulation.surroundings import GripperSetup, RobotSetup
from sim.errors import RobotError, SimulationError
from sim.robots.adapted import PREFIX, adapted, base_of
from sim.robots.derived import derived_gripper, suction_gripper
from sim.robots.gripper import Gripper
from sim.robots.robot import Robot
from sim.robots.setup import check_robot

DOWN_COSINE = 0.98
"""Least cosine of the angle between the tool's z axis at home and straight down."""


def own_robot(setup: RobotSetup) -> Robot:
    """Return the robot that a scenario describes.

    Raises:
        SimulationError: the MJCF cannot be read, or does not fit the table; the message begins with the key.
    """
    check_robot(setup)
    spec, gripper = _prepared(setup, _changed(setup))
    model = spec.compile()
    data = mujoco.MjData(model)
    names = tuple(PREFIX + joint for joint in setup.joints)
    for name, value in zip(names, setup.home, strict=True):
        low, high = model.joint(name).range
        if not low <= value <= high:
            raise SimulationError(
                f"robot.home: {value:g} is not from {low:g} to {high:g}, the range of {_plain(name)!r}"
            )
        data.joint(name).qpos[0] = value
    mujoco.mj_kinematics(model, data)
    tool = data.site(PREFIX + str(setup.tool))
    if -tool.xmat[8] < DOWN_COSINE:
        raise SimulationError(f"robot.home: the z axis of the site {setup.tool!r} does not point down there")
    robot = Robot(
        name=setup.name if setup.name != RobotSetup().name else Path(str(setup.mjcf)).stem,
        title=f"of {setup.mjcf}",
        mjcf=partial(_spec, setup),
        base=base_of(spec),
        joints=names,
        velocity_limits=np.array(setup.velocity),
        torque_limits=np.array(setup.torque),
        acceleration_limits=np.array(setup.acceleration) if setup.acceleration else np.inf,
        home=np.array(setup.home),
        tool=PREFIX + str(setup.tool),
        gripper=gripper,
    )
    if inside := _links_inside_each_other(robot, model):
        one, other = map(_plain, inside)
        raise SimulationError(
            f"robot.home: the links {one!r} and {other!r} are inside each other there; "
            "if they always are, add an `exclude` to `contact` in the MJCF"
        )
    return robot


def _links_inside_each_other(robot: Robot, model: mujoco.MjModel) -> tuple[str, str] | None:
    """Return the names of two links that overlap at home, the hand open or closed; None if there are none.

    Every log of such a robot would be refuted. Neighbours may overlap, and so may the fingers.
    """
    robot.let_links_collide(model)
    is_robot, is_finger = robot.bodies(model)[model.geom_bodyid], robot.fingers(model)
    data = mujoco.MjData(model)
    for width in (robot.gripper.opening_m, 0.0):
        robot.put(data, robot.home, width=width)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        for pair, depth in zip(data.contact.geom, data.contact.dist, strict=True):
            if depth < 0 and is_robot[pair].all() and not is_finger[pair].all():
                one, other = model.geom_bodyid[pair].tolist()
                return str(model.body(one).name), str(model.body(other).name)
    return None


def _spec(setup: RobotSetup, meshes: bool | None = None) -> mujoco.MjSpec:
    """Return the adapted robot; it has its own meshes, whatever `meshes` is."""
    return _prepared(setup, _changed(setup))[0].copy()


def _changed(setup: RobotSetup) -> int:
    """Return when the MJCF was last written, ns; raise `SimulationError` if there is none."""
    path = setup.folder / str(setup.mjcf)
    if not path.is_file():
        raise SimulationError(f"robot.mjcf: {path}: no such file")
    return path.stat().st_mtime_ns


@cache
def _prepared(setup: RobotSetup, changed: int) -> tuple[mujoco.MjSpec, Gripper]:
    """Return the adapted robot and the gripper derived from it; `changed` lets the cache notice a changed file."""
    path = setup.folder / str(setup.mjcf)
    try:
        source = mujoco.MjSpec.from_file(str(path))
        source.compile()
    except (ValueError, OSError) as error:
        raise SimulationError(f"robot.mjcf: {path}: {' '.join(str(error).split())}") from None
    assert setup.gripper is not None and setup.tool is not None
    for key, kind, names in (
        ("joints", "joint", setup.joints),
        ("tool", "site", (setup.tool,)),
        ("gripper.actuator", "actuator", (setup.gripper.actuator,)),
    ):
        _check_named(source, key, kind, names)
    driven = source.actuator(setup.gripper.actuator).target
    if driven in setup.joints:
        raise SimulationError(
            f"robot.gripper.actuator: {setup.gripper.actuator!r} drives {driven!r}, a joint of the arm"
        )
    try:
        spec = adapted(source, setup.joints, np.array(setup.torque))
        arm = {PREFIX + name: value for name, value in zip(setup.joints, setup.home, strict=True)}
        _check_kept(spec.site(PREFIX + setup.tool), "tool", setup)
        _check_kept(spec.actuator(PREFIX + setup.gripper.actuator), "gripper.actuator", setup)
        return spec, _gripper(spec, arm, setup.tool, setup.gripper)
    except (RobotError, ValueError) as error:
        raise SimulationError(f"robot: {path}: {' '.join(_plain(str(error)).split())}") from None


def _gripper(spec: mujoco.MjSpec, arm: dict[str, float], tool: str, gripper: GripperSetup) -> Gripper:
    tool, actuator = PREFIX + tool, PREFIX + gripper.actuator
    if gripper.kind == "suction":
        return suction_gripper(spec, arm, tool=tool, actuator=actuator, force_n=gripper.force)
    assert gripper.open is not None
    return derived_gripper(
        spec,
        arm,
        tool=tool,
        actuator=actuator,
        opening_m=gripper.open,
        closed_m=gripper.closed,
        force_n=gripper.force,
    )


def _check_named(spec: mujoco.MjSpec, key: str, kind: str, names: tuple[str, ...]) -> None:
    """Raise SimulationError unless the MJCF has all named parts of a kind."""
    known = [part.name for part in getattr(spec, f"{kind}s") if part.name]
    for name in names:
        if name not in known:
            raise SimulationError(f"robot.{key}: no {kind} {name!r} in the MJCF {choices(name, known)}")


def _check_kept(part: mujoco.MjsSite | mujoco.MjsActuator | None, key: str, setup: RobotSetup) -> None:
    """Raise SimulationError if `adapted` removed a part, since it does not belong to the arm."""
    if part is None:
        raise SimulationError(f"robot.{key}: {setup.joints[-1]!r}, the last joint, does not move it")


def _plain(text: str) -> str:
    return text.replace(PREFIX, "")
