"""Robots from other sources, adapted to scenes: unique names, contacts, position actuators, gravity compensation."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import cache, partial

import mujoco
import numpy as np

from prefplan.models.manipulation.surroundings import GripperSetup
from sim.errors import RobotError
from sim.robots.gripper import Gripper
from sim.robots.gripper_from_mjcf import gripper_from_mjcf
from sim.robots.robot import ArmConstants, Robot, check_parts

PREFIX = "robot:"
"""Prefix of all names of an imported robot, which could otherwise clash with those of a scenario."""

STIFFNESS_PER_TORQUE = 60.0
"""Stiffness over torque limit of an actuator that the MJCF lacks, 1/rad: about the Panda's."""

DAMPING_TIME_S = 0.1
"""Least ratio of damping to stiffness of an actuator, s: the Panda's."""


@dataclass(frozen=True, eq=False)
class ImportedArm(ArmConstants):
    """A robot from another source: an MJCF, and constants with the names in this MJCF.

    Attributes:
        mjcf: returns the MJCF, with a site for the tool.
        gripper: actuator, force and widths of the gripper; its other constants are derived from the MJCF.
    """

    mjcf: Callable[[], mujoco.MjSpec]
    gripper: GripperSetup

    def robot(self) -> Robot:
        """Return the robot; its MJCF is adapted to scenes on the first call.

        Raises `RobotError` or `ValueError` if the MJCF is not available or readable, or does not fit the constants.
        """
        spec, gripper = _imported(self)
        constants = {each.name: getattr(self, each.name) for each in fields(ArmConstants)}
        constants |= {"joints": tuple(PREFIX + joint for joint in self.joints), "tool": PREFIX + self.tool}
        base = str(spec.worldbody.first_body().name)
        return Robot(mjcf=partial(_copy, self), base=base, gripper=gripper, **constants)


@cache
def _imported(arm: ImportedArm) -> tuple[mujoco.MjSpec, Gripper]:
    """Return the robot alone, cut out of the MJCF of an arm, and its gripper.

    The robot is the top-level body above the first joint, and its descendants. Names get a prefix. Joints that are
    neither the arm's nor beyond its last joint are fixed. Each joint of the arm gets a position actuator of its name.
    """
    spec = arm.mjcf()
    actuator = arm.gripper.actuator
    check_parts(spec, joint=arm.joints, site=(arm.tool,), actuator=(actuator,))
    if (driven := spec.actuator(actuator).target) in arm.joints:
        raise RobotError(f"the actuator {actuator!r} of the gripper drives {driven!r}, a joint of the arm")
    _check_joints(spec, arm.joints)
    for element in (*spec.keys, *spec.lights, *spec.pairs, *spec.sensors):
        spec.delete(element)
    root = _root(spec.joint(arm.joints[0]).parent, spec)
    _take_out_of_frame(spec, root)
    whole = mujoco.MjSpec()
    spec.option, spec.visual, spec.stat = whole.option, whole.visual, whole.stat  # the scene has its own
    for size in ("memory", "njmax", "nconmax", "nkey"):
        setattr(spec, size, getattr(whole, size))
    whole.worldbody.add_frame().attach_body(root, PREFIX, "")
    _name(whole)
    names = [PREFIX + name for name in arm.joints]
    kept = {joint.name for joint in _joints_below(whole.joint(names[-1]).parent)}
    for joint in list(whole.joints):
        if joint.name not in (*names, *kept):
            _fix(whole, joint)
    for body in whole.bodies[1:]:
        body.gravcomp = 1
    _let_turn(whole, whole.joint(names[0]).parent)
    for name, torque in zip(names, arm.torque_limits, strict=True):
        _set_motor(whole, name, float(torque))
    for kind, name in (("site", arm.tool), ("actuator", actuator)):
        if getattr(whole, kind)(PREFIX + name) is None:
            raise RobotError(f"the {kind} {name!r} is not moved by {arm.joints[-1]!r}, the last joint")
    home = dict(zip(names, map(float, arm.home), strict=True))
    return whole, gripper_from_mjcf(whole, home, arm.gripper, tool=PREFIX + arm.tool, actuator=PREFIX + actuator)


def _copy(arm: ImportedArm) -> mujoco.MjSpec:
    """Return a copy of the robot's MJCF."""
    return _imported(arm)[0].copy()


def _check_joints(spec: mujoco.MjSpec, joints: Sequence[str]) -> None:
    """Raise RobotError unless the joints turn or slide, each by itself, and each moves the next one."""
    for name in joints:
        if spec.joint(name).type not in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
            raise RobotError(f"the joint {name!r} is neither a hinge nor a slide")
    for before, name in zip(joints, joints[1:], strict=False):
        if spec.joint(name).name not in {joint.name for joint in _joints_below(spec.joint(before).parent)}:
            raise RobotError(f"the joint {name!r} is not behind {before!r}; name the joints from base to wrist")
    for pair in spec.equalities:
        if pair.type == mujoco.mjtEq.mjEQ_JOINT and {pair.name1, pair.name2} <= {*joints}:
            raise RobotError(f"the joints {pair.name1!r} and {pair.name2!r} of the arm are coupled by an `equality`")


def _take_out_of_frame(spec: mujoco.MjSpec, root: mujoco.MjsBody) -> None:
    """Give a top-level body its pose in the world if it stands in a `frame`, which would be lost with the rest."""
    if root.frame is not None:
        model = spec.compile()
        root.pos, root.quat = model.body_pos[root.id], model.body_quat[root.id]
        root.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT


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
    driven = mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT, mujoco.mjtTrn.mjTRN_TENDON
    coupled = mujoco.mjtEq.mjEQ_JOINT, mujoco.mjtEq.mjEQ_TENDON
    motors = [motor for motor in spec.actuators if motor.trntype in driven and motor.target in gone]
    pairs = [pair for pair in spec.equalities if pair.type in coupled and {pair.name1, pair.name2} & gone]
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
    for kind, parts in (("link", spec.bodies[1:]), ("joint", spec.joints), ("shape", spec.geoms)):
        unnamed = [part for part in parts if not part.name.removeprefix(PREFIX)]
        for number, part in enumerate(unnamed, 1):
            part.name = f"{PREFIX}{kind} {number}"
    for geom in spec.geoms:
        if geom.contype or geom.conaffinity:
            geom.contype, geom.conaffinity = 2, 1


def _set_motor(spec: mujoco.MjSpec, name: str, torque: float) -> None:
    """Give a joint a position actuator of its name, with the stiffness of the MJCF's position actuator if there is one.

    The joint's damping moves to the actuator: the controller compensates for it, as for friction and springs.
    """
    joint = spec.joint(name)
    if not np.any(joint.range):
        if joint.type != mujoco.mjtJoint.mjJNT_HINGE:
            raise RobotError(f"the joint {name.removeprefix(PREFIX)!r} has no `range`")
        joint.range = [-2 * np.pi, 2 * np.pi]
    joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
    found = [motor for motor in spec.actuators if motor.target == name]
    stiffness = STIFFNESS_PER_TORQUE * torque
    for motor in found:
        if motor.biasprm[1] < 0:
            stiffness = -float(motor.biasprm[1])
        spec.delete(motor)
    damping = max(DAMPING_TIME_S * stiffness, float(joint.damping[0]))
    joint.damping[0], joint.stiffness[0], joint.frictionloss = 0.0, 0.0, 0.0
    add_servo(spec, name, joint.range, torque, stiffness, damping)


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
    """Add a position servo of a joint of its name, or of a tendon.

    Stiffness and damping are in N m/rad and N m s/rad, or N/m and N s/m; `reach` is the least and the greatest command,
    rad or m, `limit` the greatest force, N m or N.
    """
    motor = spec.add_actuator(name=name, target=tendon or name)
    motor.trntype = mujoco.mjtTrn.mjTRN_TENDON if tendon else mujoco.mjtTrn.mjTRN_JOINT
    motor.set_to_position(kp=stiffness, kv=damping)
    motor.ctrllimited = motor.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
    motor.ctrlrange, motor.forcerange = reach, [-limit, limit]
