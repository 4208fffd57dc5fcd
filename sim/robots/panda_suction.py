"""The Panda with a suction cup on its hand instead of fingers."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import trimesh

from sim.geometry.mjcf import HIDDEN, draw_solid
from sim.robots.adapted import set_pad
from sim.robots.gripper import SUCTION_OPENING_M, SUCTION_SQUEEZE_M, SuctionGripper
from sim.robots.panda import PANDA, panda_spec

CUP_DIAMETER_M, VACUUM_PA = 0.024, 60e3
"""Diameter of the cup's lip, and pressure in it below that of the air: typical of an ejector."""

FORCE_N = VACUUM_PA * np.pi * CUP_DIAMETER_M**2 / 4
"""Suction force, 27 N."""

LIP_HALF_M = CUP_DIAMETER_M * np.sqrt(np.pi) / 4
"""Half the side of a square of the lip's area, used as its geom: MuJoCo finds contacts at all four corners."""

TRAVEL_M, STIFFNESS_N_M, PRELOAD_M = 0.008, 500.0, 0.004
"""Travel of the cup on its spring, the spring's stiffness, and its compression at rest."""

CUP_MASS_KG, CUP_INERTIA_KG_M2 = 0.03, 5e-6
"""Of the cup and the moving part of the spring."""

HAND_BOTTOM_M = 0.0661
"""Distance from the hand's frame to its lower side, where the rail of the fingers is."""


def suction_spec(meshes: bool | None = None) -> mujoco.MjSpec:
    """Return the robot; arguments and errors as of `panda_spec`."""
    spec = panda_spec(meshes=meshes)
    for element in (*spec.equalities, *spec.tendons, spec.actuator(PANDA.gripper.actuator)):
        spec.delete(element)
    for name in ("left_finger", "right_finger"):
        spec.delete(spec.body(name))
    hand, tool = spec.body("hand"), spec.site(PANDA.tool).pos
    cup = hand.add_body(name="suction_cup", pos=tool, gravcomp=1)
    cup.mass, cup.inertia, cup.explicitinertial = CUP_MASS_KG, np.full(3, CUP_INERTIA_KG_M2), True
    cup.ipos = [0.0, 0.0, 0.0]  # without it MuJoCo writes no inertia
    spring = cup.add_joint(name="suction_cup", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1], range=[-TRAVEL_M, 0.0])
    spring.stiffness[0], spring.springref, spring.damping[0], spring.armature = STIFFNESS_N_M, PRELOAD_M, 5.0, 0.0
    spring.limited = mujoco.mjtLimited.mjLIMITED_TRUE
    # As stiff as the lip: with so light a cup, MuJoCo's default stop yielded by 5 mm under 1 kg.
    spring.solref_limit, spring.solimp_limit[:3] = [0.004, 1], [0.95, 0.99, 0.001]
    lip = cup.add_geom(
        name="suction_cup", type=mujoco.mjtGeom.mjGEOM_BOX, size=[LIP_HALF_M, LIP_HALF_M, 0.005], pos=[0, 0, -0.005]
    )
    lip.contype, lip.conaffinity, lip.group = 2, 1, HIDDEN
    set_pad(lip, friction=1.0)
    _draw(spec, hand, cup, float(tool[2]))
    motor = spec.add_actuator(name=SUCTION.actuator, target="suction_cup", trntype=mujoco.mjtTrn.mjTRN_BODY)
    motor.set_to_adhesion(FORCE_N)
    motor.ctrllimited, motor.ctrlrange = mujoco.mjtLimited.mjLIMITED_TRUE, [0.0, 1.0]
    return spec


def _draw(spec: mujoco.MjSpec, hand: mujoco.MjsBody, cup: mujoco.MjsBody, length: float) -> None:
    """Draw the tube that comes out of the hand, and the cup with its bellows."""
    spec.add_material(name="cup_rubber", rgba=[0.10, 0.16, 0.30, 1], specular=0.2, shininess=0.2)
    spec.add_material(name="cup_metal", rgba=[0.55, 0.56, 0.58, 1], specular=0.7, shininess=0.6)
    drop = length - HAND_BOTTOM_M
    tube = trimesh.creation.cylinder(radius=0.006, height=0.6 * drop)
    draw_solid(spec, hand, "cup_tube", tube, "cup_metal", z=HAND_BOTTOM_M + 0.3 * drop)
    rim = CUP_DIAMETER_M / 2
    outline = [(0, -0.62 * drop), (0.006, -0.62 * drop), (0.010, -0.5 * drop), (0.0075, -0.38 * drop)]
    outline += [(0.010, -0.26 * drop), (0.0075, -0.16 * drop), (rim, 0.0), (0, 0.0)]
    draw_solid(spec, cup, "cup_bellows", trimesh.creation.revolve(np.array(outline)), "cup_rubber")


SUCTION = SuctionGripper(
    actuator="gripper",
    joints=("suction_cup",),
    pads=("suction_cup",),
    opening_m=SUCTION_OPENING_M,
    squeeze_m=SUCTION_SQUEEZE_M,
    # A fifth of its force.
    firm_force_n=5.0,
    # The lip, with 2 mm of clearance.
    finger_depth_m=0.014,
    finger_half_width_m=0.014,
    fingertip_m=0.0,
    # From the lip to the hand, with 2 mm of clearance.
    palm_height_m=0.035,
    palm_half_width_m=0.034,
    force_n=FORCE_N,
)

PANDA_SUCTION = replace(
    PANDA, name="panda_suction", title="the same arm with a suction cup", mjcf=suction_spec, gripper=SUCTION
)
"""Its payload is that of the arm; what the cup holds depends on the object's height (`Gripper.held_mass`)."""
