"""MJCF from other sources, adapted for scenes: unique names, contacts, position actuators and gravity compensation."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count

import mujoco
import numpy as np

from sim.errors import RobotError
from sim.robots.robot import check_parts

PREFIX = "robot:"
"""Prefix of all names of an adapted MJCF, which could otherwise clash with those of a scenario."""

STIFFNESS_PER_TORQUE, DAMPING_TIME_S = 60.0, 0.1
"""Gains of an actuator that the MJCF lacks, about those of the Panda: stiffness over torque limit, 1/rad, and damping
over stiffness."""

WHOLE_TURN_RAD = 2 * np.pi
"""Range, either way, that a joint without limits gets."""

DRIVEN = mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT, mujoco.mjtTrn.mjTRN_TENDON
"""Kinds of actuators that drive joints and tendons."""

COUPLED = mujoco.mjtEq.mjEQ_JOINT, mujoco.mjtEq.mjEQ_TENDON
"""Kinds of equality constraints that couple joints and tendons."""


def adapted(spec: mujoco.MjSpec, joints: Sequence[str], torques: np.ndarray) -> mujoco.MjSpec:
    """Return the robot in an MJCF without the rest: the top-level body above the first joint, and its descendants.

    Names get a prefix. Joints that are neither the arm's nor beyond its last one are fixed. Each joint of the arm gets
    a position actuator with the joint's name.

    Args:
        spec: the MJCF.
        joints: of the arm, n in number, from base to wrist.
        torques: (n,) limits, N m or N.

    Raises:
        RobotError: joints are missing, or not in order from base to wrist.
    """
    check_parts(spec, joint=joints)
    _check_row(spec, joints)
    for element in (*spec.keys, *spec.lights, *spec.pairs, *spec.sensors):
        spec.delete(element)
    root = _root(spec.joint(joints[0]).parent, spec)
    whole = mujoco.MjSpec()
    spec.option = whole.option  # the scene has its own
    for size in ("memory", "njmax", "nconmax"):
        setattr(spec, size, getattr(whole, size))
    whole.worldbody.add_frame().attach_body(root, PREFIX, "")
    _name(whole)
    names = [PREFIX + name for name in joints]
    kept = {joint.name for joint in _joints_below(whole.joint(names[-1]).parent)}
    for joint in list(whole.joints):
        if joint.name not in (*names, *kept):
            _fix(whole, joint)
    for body in whole.bodies[1:]:
        body.gravcomp = 1
    _let_turn(whole, whole.joint(names[0]).parent)
    for name, torque in zip(names, torques, strict=True):
        _set_motor(whole, name, float(torque))
    return whole


def base_of(spec: mujoco.MjSpec) -> str:
    """Return the name of the root body of an adapted robot."""
    return str(spec.worldbody.first_body().name)


def _check_row(spec: mujoco.MjSpec, joints: Sequence[str]) -> None:
    """Raise RobotError unless each joint moves the next one."""
    for before, name in zip(joints, joints[1:], strict=False):
        if spec.joint(name).name not in {joint.name for joint in _joints_below(spec.joint(before).parent)}:
            raise RobotError(f"the joint {name!r} is not behind {before!r}; name the joints from base to wrist")


def _joints_below(body: mujoco.MjsBody) -> list[mujoco.MjsJoint]:
    """Return the joints of all descendants of a body, without its own."""
    return [joint for child in body.bodies for joint in child.find_all("joint")]


def _root(body: mujoco.MjsBody, spec: mujoco.MjSpec) -> mujoco.MjsBody:
    while body.parent.name != spec.worldbody.name:
        body = body.parent
    return body


def _fix(spec: mujoco.MjSpec, joint: mujoco.MjsJoint) -> None:
    """Remove a joint and the actuators, tendons and equality constraints on it."""
    name, wrapped = joint.name, mujoco.mjtWrap.mjWRAP_JOINT
    tendons = [
        tendon
        for tendon in spec.tendons
        if any(part.type == wrapped and part.target.name == name for part in tendon.path)
    ]
    gone = {name, *(tendon.name for tendon in tendons)}
    motors = [motor for motor in spec.actuators if motor.trntype in DRIVEN and motor.target in gone]
    pairs = [pair for pair in spec.equalities if pair.type in COUPLED and {pair.name1, pair.name2} & gone]
    for element in (*motors, *pairs, *tendons, joint):
        spec.delete(element)


def _let_turn(spec: mujoco.MjSpec, link: mujoco.MjsBody) -> None:
    """Exclude collisions of the first link with its ancestors: MuJoCo does so only for ancestors that move."""
    below = link.parent
    while below.name != spec.worldbody.name:
        spec.add_exclude(bodyname1=below.name, bodyname2=link.name)
        below = below.parent


def _name(spec: mujoco.MjSpec) -> None:
    """Give every body, joint and geom a name, and let colliding geoms touch the world and not each other."""
    numbers = count(1)
    for body in spec.bodies[1:]:
        body.name = body.name if body.name.removeprefix(PREFIX) else f"{PREFIX}link {next(numbers)}"
    turns = (f"{PREFIX}joint {number}" for number in count(1))
    for joint in spec.joints:
        joint.name = joint.name or next(turns)
    names = (f"{PREFIX}shape {number}" for number in count(1))
    for geom in spec.geoms:
        geom.name = geom.name or next(names)
        if geom.contype or geom.conaffinity:
            geom.contype, geom.conaffinity = 2, 1


def _set_motor(spec: mujoco.MjSpec, name: str, torque: float) -> None:
    """Give a joint a position actuator of its name, with the stiffness of the MJCF's own if it has one.

    The joint's damping becomes the actuator's, for which the controller compensates.
    """
    joint = spec.joint(name)
    if not np.any(joint.range):
        if joint.type != mujoco.mjtJoint.mjJNT_HINGE:
            raise RobotError(f"the joint {name.removeprefix(PREFIX)!r} has no `range`")
        joint.range = [-WHOLE_TURN_RAD, WHOLE_TURN_RAD]
    joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
    found = [motor for motor in spec.actuators if motor.target == name]
    stiffness = STIFFNESS_PER_TORQUE * torque
    for motor in found:
        if motor.biasprm[1] < 0:
            stiffness = -float(motor.biasprm[1])
        spec.delete(motor)
    damping = max(DAMPING_TIME_S * stiffness, float(joint.damping[0]))
    joint.damping[0], joint.frictionloss = 0.0, 0.0
    add_servo(spec, name, joint.range, torque, stiffness, damping)


def set_pad(pad: mujoco.MjsGeom, *, friction: float) -> None:
    """Give a pad stiff contacts with torsional friction; `friction` is the sliding friction."""
    pad.condim, pad.priority, pad.friction = 4, 1, [friction, 0.02, 0.0005]
    pad.solref, pad.solimp[:3] = [0.004, 1], [0.95, 0.99, 0.001]


def add_servo(
    spec: mujoco.MjSpec,
    name: str,
    reach: Sequence[float],
    limit: float,
    stiffness: float,
    damping: float,
    *,
    tendon: str | None = None,
) -> None:
    """Add a position servo.

    Args:
        spec: of the robot.
        name: of the servo, and of its joint.
        reach: least and greatest command, rad or m.
        limit: greatest force, N m or N.
        stiffness: N m/rad or N/m.
        damping: N m s/rad or N s/m.
        tendon: driven instead of a joint.
    """
    motor = spec.add_actuator(name=name, target=tendon or name)
    motor.trntype = mujoco.mjtTrn.mjTRN_TENDON if tendon else mujoco.mjtTrn.mjTRN_JOINT
    motor.set_to_position(kp=stiffness, kv=damping)
    motor.ctrllimited = motor.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
    motor.ctrlrange, motor.forcerange = reach, [-limit, limit]
