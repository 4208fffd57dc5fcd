"""The Franka Panda: MJCF, and meshes of gymnasium-robotics."""

from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import trimesh

from sim.geometry.mjcf import draw_solid
from sim.robots.arms.panda_meshes import FOLDER, surfaces
from sim.robots.assets import asset_folder, unavailable_because
from sim.robots.gripper import Gripper
from sim.robots.robot import Robot

MJCF = Path(__file__).parents[3] / "assets" / "panda.xml"


def panda_spec() -> mujoco.MjSpec:
    """Return the robot, its base frame at the origin; raise `RobotError` if gymnasium-robotics is not installed."""
    return _spec().copy()


@cache
def _spec() -> mujoco.MjSpec:
    """Return the robot; its links collide as meshes, its pads and fingers as boxes."""
    spec, folder = mujoco.MjSpec.from_file(str(MJCF)), asset_folder(FOLDER)
    bodies = {body.name: [body] for body in spec.bodies if body.name.startswith(("link", "hand"))}
    bodies["finger"] = [spec.body("left_finger"), spec.body("right_finger")]
    for link in sorted(bodies.keys() - {"finger"}):
        hull = trimesh.load_mesh(folder / "collision" / f"{link}.stl")
        spec.add_mesh(name=f"{link}_hull", uservert=hull.vertices.ravel(), userface=hull.faces.ravel())
        geom = bodies[link][0].add_geom(spec.find_default("panda"))
        geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, f"{link}_hull"
    for (link, finish), solid in surfaces(folder).items():
        for body in bodies[link]:
            draw_solid(spec, body, f"{body.name}_{finish}", solid, f"panda_{finish}")
    return spec


PANDA = Robot(
    name="panda",
    title="Franka Panda with its parallel hand",
    # Franka Emika Panda data sheet.
    payload_kg=3.0,
    mjcf=panda_spec,
    unavailable_because=unavailable_because,
    base="link0",
    joints=tuple(f"joint{i}" for i in range(1, 8)),
    # Franka Control Interface documentation, "Robot and interface specifications", "Limits for Panda".
    velocity_limits=np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61]),
    torque_limits=np.array([87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0]),
    acceleration_limits=np.array([15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0]),
    jerk_limits=np.array([7500.0, 3750.0, 5000.0, 6250.0, 7500.0, 10000.0, 10000.0]),
    torque_rate_limits=np.full(7, 1000.0),
    # Franka's ready pose.
    home=np.array([0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4]),
    tool="tcp",
    gripper=Gripper(
        actuator="gripper",
        joints=("finger_joint1", "finger_joint2"),
        pads=("left_pad", "right_pad"),
        # Franka's hand data sheet.
        opening_m=0.08,
        # The command 15 mm below a width presses with 15 N on each pad; a third of that is a firm grip.
        squeeze_m=0.015,
        firm_force_n=5.0,
        # Of the collision shapes, with 2 to 7 mm of clearance.
        finger_depth_m=0.027,
        finger_half_width_m=0.0145,
        fingertip_m=0.014,
        palm_height_m=0.030,
        palm_half_width_m=0.038,
    ),
    # Nearer to the axis, the hand would touch the robot's foot.
    nearest_m=0.32,
)
