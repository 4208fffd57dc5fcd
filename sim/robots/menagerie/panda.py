"""The Panda of MuJoCo Menagerie, with the names and the grip of the built-in Panda."""

from __future__ import annotations

from dataclasses import replace

import mujoco

from sim.errors import RobotError
from sim.geometry.mjcf import HIDDEN
from sim.robots.menagerie.download import ALTERNATIVE, fetch, hindrance
from sim.robots.panda import PANDA, panda_spec
from sim.robots.robot import check_parts

FINGERS = ("left_finger", "right_finger")


def menagerie_spec(meshes: bool | None = None) -> mujoco.MjSpec:
    """Return Menagerie's Panda with the names of the built-in one; it has its own meshes, whatever `meshes` is.

    Bodies, inertia, joints, limits, arm gains and shapes are Menagerie's. Actuator names, gravity compensation, the
    tool's site, the fingers' collision geoms and the grip are the built-in Panda's: Menagerie's grip presses a 45 mm
    block with a third of a newton.

    Raises:
        RobotError: the MJCF cannot be downloaded, or lacks an expected part.
    """
    path = fetch("panda_mj_description", "menagerie")
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        check_parts(spec, joint=PANDA.joints + PANDA.gripper.joints, body=(PANDA.base, "hand", *FINGERS))
        driven = {actuator.target for actuator in spec.actuators}
        for name in (*PANDA.joints, "split"):
            if name not in driven:
                raise RobotError(f"no actuator of {name!r} in its MJCF")
    except (ValueError, RobotError) as error:
        raise RobotError(f"{path}: the robot `menagerie` is not as expected: {error}; {ALTERNATIVE}") from None
    for element in (*spec.keys, *spec.lights):
        spec.delete(element)
    _name_actuators(spec)
    _set_grip(spec)
    _set_contacts(spec)
    spec.body("hand").add_site(name=PANDA.tool, pos=panda_spec(meshes=False).site(PANDA.tool).pos)
    for name in PANDA.joints + PANDA.gripper.joints:
        spec.joint(name).parent.gravcomp = 1
    spec.body("hand").gravcomp = 1
    return spec


def _name_actuators(spec: mujoco.MjSpec) -> None:
    for actuator in spec.actuators:
        actuator.name = actuator.target if actuator.target in PANDA.joints else PANDA.gripper.actuator


def _set_grip(spec: mujoco.MjSpec) -> None:
    """Let the gripper's command be the width between the pads, with the stiffness of the built-in gripper.

    The length of Menagerie's tendon `split` is half the width, and each finger gets half of its force; the built-in
    tendon has the full width and gives the full force. Hence twice the gain per command, four times per length.
    """
    own = panda_spec(meshes=False).actuator(PANDA.gripper.actuator)
    gripper = spec.actuator(PANDA.gripper.actuator)
    gripper.gainprm[0] = 2 * own.gainprm[0]
    gripper.biasprm[:3] = 4 * own.biasprm[:3]
    gripper.ctrlrange = [0.0, PANDA.gripper.opening_m]
    gripper.forcerange = 2 * own.forcerange


def _set_contacts(spec: mujoco.MjSpec) -> None:
    """Exclude collisions between the robot's own geoms, and give the fingers the built-in boxes and pads."""
    for geom in list(spec.geoms):
        if not geom.contype and not geom.conaffinity:
            continue
        if geom.parent.name in FINGERS:
            spec.delete(geom)
        else:
            geom.contype, geom.conaffinity, geom.group = 2, 1, HIDDEN
    own = panda_spec(meshes=False)
    for finger in FINGERS:
        for source in own.body(finger).geoms:
            geom = spec.body(finger).add_geom(name=source.name, type=source.type, size=source.size, pos=source.pos)
            geom.contype, geom.conaffinity, geom.group = source.contype, source.conaffinity, HIDDEN
            geom.friction, geom.condim, geom.priority = source.friction, source.condim, source.priority
            geom.solref, geom.solimp = source.solref, source.solimp


MENAGERIE_PANDA = replace(
    PANDA,
    name="menagerie",
    title="the same arm and hand, of MuJoCo Menagerie",
    mjcf=menagerie_spec,
    hindrance=hindrance,
)
