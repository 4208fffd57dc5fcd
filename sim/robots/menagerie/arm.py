"""An arm of Menagerie: its constants, and the gripper derived from its MJCF."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, partial

import mujoco
import numpy as np

from sim.errors import RobotError
from sim.robots.adapted import PREFIX, adapted
from sim.robots.derived import derived_gripper
from sim.robots.gripper import Gripper
from sim.robots.menagerie.download import ALTERNATIVE, fetch, hindrance
from sim.robots.robot import Robot, check_parts

HAND = "hand_"
"""Prefix of the names of a mounted hand."""


@dataclass(frozen=True)
class Mounted:
    """A hand of another MJCF on an arm.

    Attributes:
        description: module of robot_descriptions.
        root: name of its root body.
        flange: body of the arm that carries it.
        pos: of its frame in the flange's, m.
        quat: orientation of its frame, z out of the arm.
    """

    description: str
    root: str
    flange: str
    pos: tuple[float, float, float]
    quat: tuple[float, float, float, float]


@dataclass(frozen=True)
class MenagerieHand:
    """Constants of a hand; names are those of the MJCF, a mounted hand's with `HAND` before them.

    Attributes:
        tool: body with the axes of the tool frame: z out of the hand; the fingers close along y.
        tool_m: distance of the tool from that body along z.
        actuator: of the fingers.
        opening_m: greatest width.
        force_n: of each pad.
        mounted: a hand from another MJCF; None for the arm's own.
    """

    tool: str
    tool_m: float
    actuator: str
    opening_m: float
    force_n: float
    mounted: Mounted | None = None


@dataclass(frozen=True)
class MenagerieArm:
    """Constants of an arm and its hand; names are those of the MJCF.

    Attributes:
        name: by which the robot is chosen.
        title: description in words.
        description: module of robot_descriptions.
        base: root body, which is moved to the origin.
        joints: of the arm, n in number.
        velocity: (n,) limits, rad/s.
        torque: (n,) limits, N m.
        home: (n,) rad.
        hand: of the arm.
        payload_kg: greatest mass that it may carry.
        nearest_m: least distance of the tool from the axis of the base.
    """

    name: str
    title: str
    description: str
    base: str
    joints: tuple[str, ...]
    velocity: tuple[float, ...]
    torque: tuple[float, ...]
    home: tuple[float, ...]
    hand: MenagerieHand
    payload_kg: float
    nearest_m: float


UNKNOWN = Gripper("", (), ("", ""), 0, 0, 0, 0, 0, 0, 0, 0)
"""Placeholder for a gripper that is not derived yet."""


def menagerie_robot(arm: MenagerieArm) -> Robot:
    """Return the robot; `Robot.completed` downloads its MJCF and derives its gripper."""
    return Robot(
        name=arm.name,
        title=arm.title,
        mjcf=partial(_spec, arm),
        hindrance=hindrance,
        base=PREFIX + arm.base,
        joints=tuple(PREFIX + joint for joint in arm.joints),
        velocity_limits=np.array(arm.velocity),
        torque_limits=np.array(arm.torque),
        home=np.array(arm.home),
        tool=PREFIX + TOOL,
        gripper=UNKNOWN,
        find_gripper=partial(_gripper, arm),
        nearest_m=arm.nearest_m,
        payload_kg=arm.payload_kg,
    )


TOOL = "tool"
"""Name of the site that is added for the tool."""


def _spec(arm: MenagerieArm, meshes: bool | None = None) -> mujoco.MjSpec:
    """Return the adapted robot; it has its own meshes, whatever `meshes` is."""
    return _prepared(arm)[0].copy()


def _gripper(arm: MenagerieArm) -> Gripper:
    return _prepared(arm)[1]


@cache
def _prepared(arm: MenagerieArm) -> tuple[mujoco.MjSpec, Gripper]:
    """Return the adapted robot, and the gripper derived from it.

    Raises:
        RobotError: the MJCF cannot be downloaded, or lacks an expected part.
    """
    path, hand = fetch(arm.description, arm.name), arm.hand
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        check_parts(spec, body=(arm.base,), joint=arm.joints)
        spec.body(arm.base).pos = [0, 0, 0]
        if hand.mounted is not None:
            _mount(spec, hand.mounted, arm.name)
        check_parts(spec, body=(hand.tool,), actuator=(hand.actuator,))
        spec.body(hand.tool).add_site(name=TOOL, pos=[0, 0, hand.tool_m])
        whole = adapted(spec, arm.joints, np.array(arm.torque))
        gripper = derived_gripper(
            whole,
            {PREFIX + joint: value for joint, value in zip(arm.joints, arm.home, strict=True)},
            tool=PREFIX + TOOL,
            actuator=PREFIX + hand.actuator,
            opening_m=hand.opening_m,
            force_n=hand.force_n,
        )
    except (ValueError, RobotError) as error:
        raise RobotError(f"{path}: the robot `{arm.name}` is not as expected: {error}; {ALTERNATIVE}") from None
    return whole, gripper


def _mount(spec: mujoco.MjSpec, hand: Mounted, robot: str) -> None:
    source = mujoco.MjSpec.from_file(str(fetch(hand.description, robot)))
    check_parts(source, body=(hand.root,))
    check_parts(spec, body=(hand.flange,))
    source.option = spec.option
    frame = spec.body(hand.flange).add_frame(pos=hand.pos, quat=hand.quat)
    frame.attach_body(source.body(hand.root), HAND, "")
