"""The Fetch Mobile Manipulator's arm and gripper, its base and torso fixed: MJCF and meshes of gymnasium-robotics."""

from pathlib import Path

import mujoco
import numpy as np
import trimesh

from prefplan.models.manipulation.surroundings import GripperSetup
from sim.geometry.mjcf import HIDDEN, VISIBLE, draw_solid, yaw_quat
from sim.geometry.solids import smoothed
from sim.robots.assets import asset_folder, unavailable_because
from sim.robots.import_mjcf import ImportedArm, add_servo

FETCH_PREFIX = "robot0:"
"""Prefix of all names in the MJCF."""

TABLE_HEIGHT_M = 0.72
"""Height of the table top above the floor, on which the base stands, m."""

TORSO_LIFT_M = 0.3861
"""Joint position of the torso, m: fully raised, so that the forearm is well above the table."""

HEAD_PAN_RAD = np.pi / 2
"""Turn of the head, rad: turned aside, it does not obstruct the upper arm, which is raised to reach near objects."""

SHOULDER_M = 0.0326
"""Distance from the middle of the base to the shoulder's axis, which is the axis of the robot here, m."""

TOOL_M = 0.026
"""Distance from the gripper's frame to the tool, m: 12.5 mm short of the fingertips."""

CLOSED_GAP_M = 0.0018
"""Gap between the pads of the closed gripper in the MJCF, m; here, the pads meet."""

FINGER_MASS_KG = 0.0798
"""Mass of a finger, kg, from Fetch Robotics' URDF (the MJCF has 4 kg)."""

FINGER_INERTIA_KG_M2 = 2e-5
"""Inertia of a box of this mass and of the finger's size, kg m^2."""

ARMATURE_KG_M2 = 0.1
"""Armature of an arm joint, kg m^2: the Panda's, as Fetch's is not published. The MJCF has 1 and 2.75, to follow a
mocap body."""

DAMPING_N_M_S = 1.0
"""Damping of an arm joint, N m s: that of most joints in the URDF. The MJCF has 50, to follow a mocap body."""

FINGER_ARMATURE_KG = 0.1
"""Armature of a finger, kg: that of the Panda's fingers."""

FINGER_DAMPING_N_S_M = 1.0
"""Damping of a finger, N s/m: that of the Panda's fingers."""

OPENING_M = 0.10
"""Greatest width of the gripper, m, by Fetch Robotics' data sheet."""

GRIP_FORCE_N = 60.0
"""Greatest force of a finger, N, as in the URDF."""

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


def fetch_mjcf() -> mujoco.MjSpec:
    """Return the robot with its shoulder's axis over the origin, its torso raised, and an actuator for its gripper.

    Bodies, arm inertias and shapes are the MJCF's. Armatures, dampings and the grip are set here. Raises `RobotError`
    if gymnasium-robotics is not installed.
    """
    folder, stl = asset_folder("fetch"), asset_folder("stls/fetch")
    files = {name: (folder / name).read_bytes() for name in ("shared.xml", "robot.xml")}
    spec = mujoco.MjSpec.from_string(FETCH_MJCF.format(meshes=stl), include=files)
    _strip(spec)
    _dress(spec, stl)
    spec.body(f"{FETCH_PREFIX}base_link").pos = [-SHOULDER_M, 0.0, -TABLE_HEIGHT_M]
    spec.body(f"{FETCH_PREFIX}torso_lift_link").pos[2] += TORSO_LIFT_M
    spec.body(f"{FETCH_PREFIX}head_pan_link").quat = yaw_quat(HEAD_PAN_RAD)
    for name in FETCH.joints:
        joint = spec.joint(name)
        joint.armature, joint.damping[0], joint.stiffness[0] = ARMATURE_KG_M2, DAMPING_N_M_S, 0.0
    _set_gripper(spec)
    return spec


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
        # In a written MJCF, a geom without a material takes that of its class.
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
        colour = f"fetch_{COLOURS.get(link, 'white')}"
        draw_solid(spec, geom.parent, f"fetch_{link}", smoothed(solid), colour, pos=geom.pos)


def _set_gripper(spec: mujoco.MjSpec) -> None:
    """Give the gripper one actuator for the width between the pads (the whole fingers), and add the tool's site."""
    # The tool's z axis is the hand's x axis; both have the same y axis, along which the fingers close.
    quat = [np.sqrt(0.5), 0, np.sqrt(0.5), 0]
    spec.body(f"{FETCH_PREFIX}gripper_link").add_site(name=FETCH.tool, pos=[TOOL_M, 0, 0], quat=quat)
    fingers = [f"{FETCH_PREFIX}{side}_gripper_finger" for side in ("l", "r")]
    width = spec.add_tendon(name="gripper_width")
    for finger in fingers:
        joint, geom = spec.joint(f"{finger}_joint"), spec.geom(f"{finger}_link")
        link = joint.parent
        link.mass, link.inertia = FINGER_MASS_KG, np.full(3, FINGER_INERTIA_KG_M2)
        link.pos[1] -= np.sign(link.pos[1]) * CLOSED_GAP_M / 2
        joint.armature, joint.damping[0] = FINGER_ARMATURE_KG, FINGER_DAMPING_N_S_M
        joint.solref_limit, joint.solimp_limit = [0.02, 1], [0.9, 0.95, 0.001, 0.5, 2]
        geom.material, geom.group, geom.friction[0] = "fetch_grey", VISIBLE, 1.2
        width.wrap_joint(joint.name, 1.0)
    together = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, name1=f"{fingers[0]}_joint", name2=f"{fingers[1]}_joint")
    together.solref, together.solimp[:3] = [0.005, 1], [0.95, 0.99, 0.001]
    together.data[:2] = [0.0, 1.0]
    add_servo(spec, "gripper", [0.0, OPENING_M], GRIP_FORCE_N, 1000.0, 50.0, tendon="gripper_width")


FETCH = ImportedArm(
    "fetch",
    title="Fetch's arm with its parallel gripper, its base and torso fixed",
    mjcf=fetch_mjcf,
    unavailable_because=unavailable_because,
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
    gripper=GripperSetup("parallel", "gripper", force=GRIP_FORCE_N, open=OPENING_M),
    # Farther back than a Panda at the origin, so that all of a table laid out for the Panda is within reach.
    position=np.array([-0.12, 0.0, 0.0]),
    # The round base, with 6 mm of clearance.
    floor_front_m=0.26,
    nearest_m=0.32,
    # Fetch Robotics' data sheet.
    payload_kg=6.0,
)
