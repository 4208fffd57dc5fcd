"""The Fetch Mobile Manipulator's arm and gripper, its base and torso fixed: MJCF and meshes of gymnasium-robotics."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import trimesh

from sim.errors import RobotError
from sim.geometry.mjcf import HIDDEN, VISIBLE, add_solid, yaw_quat
from sim.geometry.solids import smoothed
from sim.robots.adapted import DAMPING_TIME_S, STIFFNESS_PER_TORQUE, WHOLE_TURN_RAD, add_servo, set_pad
from sim.robots.gripper import Gripper
from sim.robots.meshes import asset_folder
from sim.robots.robot import Robot

FETCH_PREFIX = "robot0:"
"""Prefix of all names in the MJCF."""

TABLE_HEIGHT_M = 0.72
"""Height of the table top above the floor, on which the base stands."""

TORSO_LIFT_M = 0.3861
"""Joint position of the torso: fully raised, so that the forearm is well above the table."""

HEAD_PAN_RAD = np.pi / 2
"""The head is turned aside: otherwise, it would obstruct the upper arm, which is raised to reach near objects."""

SHOULDER_M = 0.0326
"""Distance from the middle of the base to the shoulder's axis, which is the axis of the robot here."""

TOOL_M = 0.026
"""Distance from the gripper's frame to the tool: 12.5 mm short of the fingertips."""

CLOSED_GAP_M = 0.0018
"""Gap between the pads of the closed gripper in the MJCF; here, they meet."""

FINGER_MASS_KG, FINGER_INERTIA_KG_M2 = 0.0798, 2e-5
"""Mass of a finger, from Fetch Robotics' URDF (the MJCF has 4 kg), and inertia of a box of that mass and its size."""

ARMATURE_KG_M2, DAMPING_N_M_S = 0.1, 1.0
"""Of a joint of the arm. The armature is not published; this is the Panda's. The damping is that of most joints in the
URDF. The MJCF has armatures of 1 and 2.75 and dampings of 50, to follow a mocap body."""

FINGER_ARMATURE_KG, FINGER_DAMPING_N_S_M = 0.1, 1.0
"""Of a finger: those of the Panda's fingers."""

GRIP_FORCE_N = 60.0
"""Greatest force of a finger, as in the URDF."""

PALETTE = {
    "white": (0.86, 0.87, 0.88, 1),
    "blue": (0.06, 0.34, 0.62, 1),
    "grey": (0.25, 0.26, 0.28, 1),
    "red": (0.70, 0.05, 0.05, 1),
}

COLOURS = {
    **dict.fromkeys(("base_link", "head_pan_link", "laser_link", "gripper_link"), "grey"),
    **dict.fromkeys(("head_tilt_link", "torso_fixed_link"), "blue"),
    **dict.fromkeys(("shoulder_lift_link", "elbow_flex_link", "wrist_flex_link"), "blue"),
    "estop_link": "red",
}
"""Colour of each link that is not white."""

FETCH_MJCF = """<mujoco>
  <compiler angle="radian" meshdir="{meshes}"/>
  <include file="shared.xml"/>
  <worldbody><include file="robot.xml"/></worldbody>
</mujoco>"""


def fetch_spec(meshes: bool | None = None) -> mujoco.MjSpec:
    """Return the robot, its shoulder's axis over the origin; it has its own meshes, whatever `meshes` is.

    Bodies, arm inertias and shapes are the MJCF's. Actuators, dampings and the grip are set here.

    Raises:
        RobotError: gymnasium-robotics is not installed.
    """
    folder, stl = asset_folder("fetch"), asset_folder("stls/fetch")
    if folder is None or stl is None:
        raise RobotError(f"the robot `fetch` is not available here: {hindrance()}; the robot `panda` is")
    return _spec(folder, stl).copy()


@cache
def _spec(folder: Path, stl: Path) -> mujoco.MjSpec:
    """Return the robot by the folders of its MJCF and of its links' meshes."""
    files = {name: (folder / name).read_bytes() for name in ("shared.xml", "robot.xml")}
    spec = mujoco.MjSpec.from_string(FETCH_MJCF.format(meshes=stl), include=files)
    _strip(spec)
    _dress(spec, stl)
    _fix_base(spec)
    _set_motors(spec)
    _set_gripper(spec)
    return spec


def hindrance() -> str | None:
    """Return why the robot is not available on this machine; None if it is."""
    return None if asset_folder("fetch") else "it needs the package gymnasium-robotics: pip install gymnasium-robotics"


def _strip(spec: mujoco.MjSpec) -> None:
    """Remove the parts for gymnasium-robotics' own tasks: a mocap body that pulls the hand, cameras, textures."""
    spec.delete(spec.body(f"{FETCH_PREFIX}mocap"))
    for element in (*spec.equalities, *spec.cameras, *spec.textures, *spec.materials):
        spec.delete(element)


def _dress(spec: mujoco.MjSpec, folder: Path) -> None:
    """Use the links' convex hulls for collisions, and add smooth, coloured visual meshes."""
    for name, rgba in PALETTE.items():
        spec.add_material(name=f"fetch_{name}", rgba=rgba, specular=0.35, shininess=0.4)
    for geom in spec.geoms:
        geom.contype, geom.conaffinity, geom.margin = 2, 1, 0.0
        # Written as MJCF, a geom without a material has its class's.
        geom.material = geom.classname.geom.material = ""
    for mesh in list(spec.meshes):
        geom = spec.geom(mesh.name)
        if geom is None:
            spec.delete(mesh)
            continue
        solid = trimesh.load_mesh(folder / mesh.file)
        mesh.file, mesh.uservert, mesh.userface = "", solid.vertices.ravel(), solid.faces.ravel()
        geom.group = HIDDEN
        link = mesh.name.removeprefix(FETCH_PREFIX)
        add_solid(spec, f"fetch_{link}", smoothed(solid))
        drawn = geom.parent.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=f"fetch_{link}", pos=geom.pos)
        drawn.contype = drawn.conaffinity = drawn.mass = 0
        drawn.material, drawn.group, drawn.rgba = f"fetch_{COLOURS.get(link, 'white')}", VISIBLE, [0.5, 0.5, 0.5, 1]


def _fix_base(spec: mujoco.MjSpec) -> None:
    """Put the base on the floor, raise the torso and fix every joint but those of the arm and the fingers."""
    spec.body(f"{FETCH_PREFIX}base_link").pos = [-SHOULDER_M, 0.0, -TABLE_HEIGHT_M]
    spec.body(f"{FETCH_PREFIX}torso_lift_link").pos[2] += TORSO_LIFT_M
    spec.body(f"{FETCH_PREFIX}head_pan_link").quat = yaw_quat(HEAD_PAN_RAD)
    for joint in list(spec.joints):
        if joint.name not in (*FETCH.joints, *FETCH.gripper.joints):
            spec.delete(joint)


def _set_motors(spec: mujoco.MjSpec) -> None:
    for name, limit in zip(FETCH.joints, FETCH.torque_limits, strict=True):
        joint = spec.joint(name)
        joint.armature, joint.damping[0], joint.stiffness[0] = ARMATURE_KG_M2, DAMPING_N_M_S, 0.0
        if not np.any(joint.range):
            joint.range = [-WHOLE_TURN_RAD, WHOLE_TURN_RAD]
        joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        joint.parent.gravcomp = 1
        stiffness = STIFFNESS_PER_TORQUE * limit
        add_servo(spec, name, joint.range, limit, stiffness, DAMPING_TIME_S * stiffness)


def _set_gripper(spec: mujoco.MjSpec) -> None:
    """Give the gripper one actuator for the width between the pads (the whole fingers), and add the tool's site."""
    hand, gripper = spec.body(f"{FETCH_PREFIX}gripper_link"), FETCH.gripper
    hand.gravcomp = 1
    # The tool's z axis is the hand's x axis; both have the same y axis, along which the fingers close.
    hand.add_site(name=FETCH.tool, pos=[TOOL_M, 0, 0], quat=[np.sqrt(0.5), 0, np.sqrt(0.5), 0])
    width = spec.add_tendon(name="gripper_width")
    for name, pad in zip(gripper.joints, gripper.pads, strict=True):
        joint, geom = spec.joint(name), spec.geom(pad)
        finger = joint.parent
        finger.gravcomp, finger.mass, finger.inertia = 1, FINGER_MASS_KG, np.full(3, FINGER_INERTIA_KG_M2)
        finger.pos[1] -= np.sign(finger.pos[1]) * CLOSED_GAP_M / 2
        joint.armature, joint.damping[0] = FINGER_ARMATURE_KG, FINGER_DAMPING_N_S_M
        joint.solref_limit, joint.solimp_limit = [0.02, 1], [0.9, 0.95, 0.001, 0.5, 2]
        set_pad(geom, friction=1.2)
        geom.material, geom.group = "fetch_grey", VISIBLE
        width.wrap_joint(name, 1.0)
    together = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, name1=gripper.joints[0], name2=gripper.joints[1])
    together.solref, together.solimp[:3] = [0.005, 1], [0.95, 0.99, 0.001]
    together.data[:2] = [0.0, 1.0]
    reach = [0.0, gripper.opening_m]
    add_servo(spec, gripper.actuator, reach, GRIP_FORCE_N, 1000.0, 50.0, tendon="gripper_width")


FETCH = Robot(
    name="fetch",
    title="Fetch's arm with its parallel gripper, its base and torso fixed",
    mjcf=fetch_spec,
    hindrance=hindrance,
    base=f"{FETCH_PREFIX}base_link",
    joints=tuple(
        f"{FETCH_PREFIX}{name}_joint"
        for name in (
            "shoulder_pan",
            "shoulder_lift",
            "upperarm_roll",
            "elbow_flex",
            "forearm_roll",
            "wrist_flex",
            "wrist_roll",
        )
    ),
    # Fetch Robotics, fetch_description/robots/fetch.urdf: `velocity` and `effort` of each joint.
    velocity_limits=np.array([1.256, 1.454, 1.571, 1.521, 1.571, 2.268, 2.268]),
    torque_limits=np.array([33.82, 131.76, 76.94, 66.18, 29.35, 25.7, 7.36]),
    # Fetch Robotics, fetch_moveit_config/config/joint_limits.yaml: limits for planning. Peak accelerations, jerks and
    # torque rates are not published.
    acceleration_limits=np.array([1.5, 1.0, 1.5, 1.5, 1.5, 2.5, 2.5]),
    peak_acceleration_limits=np.inf,
    # The tool 0.5 m from the shoulder's axis and 0.4 m above the table.
    home=np.array([0.0, -0.6, 0.0, 1.2, 0.0, np.pi / 2 - 0.6, 0.0]),
    tool="tcp",
    gripper=Gripper(
        actuator="gripper",
        joints=(f"{FETCH_PREFIX}l_gripper_finger_joint", f"{FETCH_PREFIX}r_gripper_finger_joint"),
        pads=(f"{FETCH_PREFIX}l_gripper_finger_link", f"{FETCH_PREFIX}r_gripper_finger_link"),
        # Fetch Robotics' data sheet.
        opening_m=0.10,
        squeeze_m=0.015,
        firm_force_n=5.0,
        # From the shapes, with 1.5 to 2 mm of clearance.
        finger_depth_m=0.016,
        finger_half_width_m=0.0155,
        fingertip_m=0.014,
        palm_height_m=0.056,
        palm_half_width_m=0.042,
    ),
    # Farther back than a Panda at the origin, so that all of a table laid out for the Panda is within reach.
    position=np.array([-0.12, 0.0, 0.0]),
    # The round base, with 6 mm of clearance.
    floor_front_m=0.26,
    nearest_m=0.32,
    # The shoulder turns 92 degrees.
    max_bearing_rad=np.radians(90),
    # Fetch Robotics' data sheet.
    payload_kg=6.0,
)
