"""The constants of a gripper, derived from its MJCF: pads, linkage, forces and dimensions."""

import copy
from typing import Any

import mujoco
import numpy as np

from prefplan.models.manipulation.surroundings import GripperSetup
from sim.errors import RobotError
from sim.geometry.mjcf import box_corners, with_descendants
from sim.robots.gripper import SUCTION_OPENING_M, SUCTION_SQUEEZE_M, Gripper, Linkage, SuctionGripper

COMMANDS = 25
"""Number of commands, from the least to the greatest, at which the fingers are measured."""

SETTLE_S = 0.6
"""Time for the fingers to come to rest at each command, s."""

MIN_TRAVEL_M = 0.005
"""Least range of the widths between the pads over all commands, m."""

WIDTH_TOLERANCE_M = 0.002
"""Greatest shortfall of the measured range of widths at either end of the specified range, m."""

SHAPE_MARGIN_M = 0.002
"""Clearance added to all shapes of the hand, m."""

SQUEEZES_M = 0.006, 0.020
"""Bounds on `Gripper.squeeze_m`, m."""

FIRM_SHARE = 1 / 3
"""Least force of a firm grip, as a share of the gripper's force."""

FIRM_FORCE_N = 5.0
"""Force that is enough for a firm grip of any gripper, N."""

CLOSING_COSINE = 0.98
"""Least cosine of the angle between the tool's y axis and the closing direction of the fingers."""

MAX_PALM_M = 0.06
"""Greatest half width of a palm, m; wider shapes are parts of the arm."""

USUAL_PALM_M = 0.05
"""Height of the palm above the tool if the hand has no shapes there, m."""

RIGID_PRESS_M = 0.0003
"""How far a cup without a spring moves on after touching an object, m: a millimetre would push the object away."""


def _set_pad(pad: mujoco.MjsGeom) -> None:
    """Give a pad stiff contacts with torsional friction, and a sliding friction of at least 1."""
    pad.condim, pad.priority, pad.friction = 4, 1, [max(1.0, float(pad.friction[0])), 0.02, 0.0005]
    pad.solref, pad.solimp[:3] = [0.004, 1], [0.95, 0.99, 0.001]


def gripper_from_mjcf(
    spec: mujoco.MjSpec, arm: dict[str, float], setup: GripperSetup, *, tool: str, actuator: str
) -> Gripper:
    """Return the gripper of an imported robot.

    Args:
        spec: of the robot; the contacts of its pads and the force of its actuator are changed.
        arm: home position of each joint of the arm, rad or m.
        setup: kind, widths and force of the gripper.
        tool: site between the pads or at the lip of the cup: z points out of the hand, the fingers close along y.
        actuator: name in `spec` of the actuator of `setup`.

    Raises:
        RobotError: the fingers do not close along the tool's y axis, or not over the widths of `setup`; the actuator
            is of the wrong kind; the cup does not have exactly one colliding geom.
    """
    if setup.kind == "suction":
        return _suction(spec, arm, tool, actuator, setup.force)
    assert setup.open is not None
    opening_m, closed_m, force_n = setup.open, setup.closed, setup.force
    model = spec.compile()
    joints = tuple(model.joint(i).name for i in range(model.njnt) if model.joint(i).name not in arm)
    states = _states(model, arm, actuator)
    pads = _pads(states[len(states) // 2], joints, tool)
    widths = np.array([_width(state, pads, tool) for state in states])
    order = np.argsort(widths)
    if np.ptp(widths) < MIN_TRAVEL_M:
        raise RobotError(
            f"the actuator {actuator!r} does not move the fingers apart along the y axis of the site {tool!r}"
        )
    if widths.max() < opening_m - WIDTH_TOLERANCE_M or widths.min() > closed_m + WIDTH_TOLERANCE_M:
        found = f"{widths.min():.3f} to {widths.max():.3f} m"
        raise RobotError(f"the fingers should open from {closed_m:g} to {opening_m:g} m, but their range is {found}")
    _check_axis(states[order[-1]], pads, tool)
    apart = order[np.diff(widths[order], prepend=-np.inf) > 1e-5]
    kept = [states[i] for i in apart]
    linkage = Linkage(
        widths=widths[apart],
        commands=np.array([state.actuator(actuator).ctrl[0] for state in kept]),
        positions=np.array([[state.joint(name).qpos[0] for name in joints] for state in kept]),
    )
    lengths = np.array([state.actuator(actuator).length[0] for state in kept])
    squeeze = _set_force(spec, actuator, linkage, lengths, force_n)
    for pad in map(spec.geom, pads):
        _set_pad(pad)
    sizes = _dimensions(states, joints, pads, tool)
    return Gripper(actuator, joints, pads, opening_m, squeeze, _firm(force_n), **sizes, linkage=linkage)


def _states(model: mujoco.MjModel, arm: dict[str, float], actuator: str) -> list[mujoco.MjData]:
    """Return the hand at rest at each of several commands, the arm held at home."""
    option = model.opt
    option.integrator, option.timestep = mujoco.mjtIntegrator.mjINT_IMPLICITFAST, 0.002
    option.gravity[:] = 0
    motor = model.actuator(actuator).id
    if not model.actuator_ctrllimited[motor]:
        raise RobotError(f"the actuator {actuator!r} has no `ctrlrange`")
    data = mujoco.MjData(model)
    for name, value in arm.items():
        data.joint(name).qpos[0] = data.actuator(name).ctrl[0] = value
    found = []
    low, high = model.actuator_ctrlrange[motor].tolist()
    for command in np.linspace(low, high, COMMANDS):
        data.ctrl[motor] = command
        mujoco.mj_step(model, data, round(SETTLE_S / option.timestep))
        for name, value in arm.items():
            data.joint(name).qpos[0], data.joint(name).qvel[0] = value, 0.0
        mujoco.mj_forward(model, data)
        found.append(copy.copy(data))
    return found


def _pads(data: mujoco.MjData, joints: tuple[str, ...], tool: str) -> tuple[str, str]:
    """Return the geom of the left and of the right finger that is nearest to the tool: these are the pads."""
    model, site = data.model, data.site(tool)
    moving = with_descendants(model, *(model.joint(name).bodyid[0] for name in joints))
    shapes = np.flatnonzero(moving[model.geom_bodyid] & (model.geom_contype != 0)).tolist()
    across = (data.geom_xpos[shapes] - site.xpos) @ site.xmat.reshape(3, 3)[:, 1]
    left, right = ([i for i, y in zip(shapes, across, strict=True) if y * side > 0] for side in (1, -1))
    if not left or not right:
        raise RobotError(f"no finger has a colliding shape on either side of the site {tool!r}, along its y axis")
    nearest = [
        min(side, key=lambda geom: float(np.linalg.norm(data.geom_xpos[geom] - site.xpos))) for side in (left, right)
    ]
    return model.geom(nearest[0]).name, model.geom(nearest[1]).name


def _suction(spec: mujoco.MjSpec, arm: dict[str, float], tool: str, actuator: str, force_n: float) -> SuctionGripper:
    """Return a gripper with one suction cup, an adhesion actuator on a body with one geom."""
    motor = spec.actuator(actuator)
    if motor.trntype != mujoco.mjtTrn.mjTRN_BODY:
        raise RobotError(f"the actuator {actuator!r} is no adhesion actuator")
    lips = [geom for geom in spec.body(motor.target).geoms if geom.contype]
    if len(lips) != 1:
        raise RobotError(f"the body {motor.target!r} of the suction cup has {len(lips)} colliding shapes, not one")
    motor.set_to_adhesion(force_n)
    motor.ctrllimited, motor.ctrlrange = mujoco.mjtLimited.mjLIMITED_TRUE, [0.0, 1.0]
    (lip,) = lips
    _set_pad(lip)
    model = spec.compile()
    data = mujoco.MjData(model)
    for name, value in arm.items():
        data.joint(name).qpos[0] = value
    mujoco.mj_kinematics(model, data)
    joints = tuple(model.joint(i).name for i in range(model.njnt) if model.joint(i).name not in arm)
    sizes = _dimensions([data], joints, (lip.name,), tool)
    sizes |= {"finger_depth_m": sizes["finger_half_width_m"], "fingertip_m": 0.0, "force_n": force_n}
    sizes["press_m"] = SuctionGripper.press_m if spec.body(motor.target).joints else RIGID_PRESS_M
    return SuctionGripper(actuator, joints, (lip.name,), SUCTION_OPENING_M, SUCTION_SQUEEZE_M, _firm(force_n), **sizes)


def _firm(force_n: float) -> float:
    """Return the least force of a firm grip, N, by the gripper's greatest force, N."""
    return min(FIRM_FORCE_N, FIRM_SHARE * force_n)


def _width(data: mujoco.MjData, pads: tuple[str, ...], tool: str) -> float:
    """Return the width between the pads, measured by their bounding boxes in the tool's frame, m."""
    left, right = (_box(data, data.model.geom(name).id, tool)[:, 1] for name in pads)
    return float(left.min() - right.max())


def _check_axis(data: mujoco.MjData, pads: tuple[str, str], tool: str) -> None:
    """Raise RobotError unless the shortest line between the open pads is along the tool's y axis."""
    ends = np.zeros(6)
    left, right = (data.model.geom(name).id for name in pads)
    mujoco.mj_geomDistance(data.model, data, left, right, 1.0, ends)
    apart = ends[:3] - ends[3:]
    axes = data.site(tool).xmat.reshape(3, 3)
    if abs(apart @ axes[:, 1]) < CLOSING_COSINE * np.linalg.norm(apart):
        raise RobotError(f"the fingers do not close along the y axis of the site {tool!r}")


def _set_force(spec: mujoco.MjSpec, actuator: str, linkage: Linkage, lengths: np.ndarray, force_n: float) -> float:
    """Limit the actuator so that each pad presses with a given force; return the `squeeze_m` for this force, m.

    By virtual work, a pad's force is the actuator's force times the derivative of the actuator's length by the width.
    """
    motor = spec.actuator(actuator)
    slope = float(np.abs(np.polyfit(linkage.widths, lengths, 1)[0]))
    motor.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
    motor.forcerange = [-force_n / slope, force_n / slope]
    stiffness = -float(motor.biasprm[1]) * slope**2
    if stiffness <= 0:
        raise RobotError(f"the actuator {actuator!r} is no position servo")
    squeeze = force_n / stiffness
    if squeeze > SQUEEZES_M[1]:  # so soft a servo would press with less force
        stiffer = squeeze / SQUEEZES_M[1]
        motor.gainprm[0] *= stiffer
        motor.biasprm[:3] *= [stiffer, stiffer, np.sqrt(stiffer)]  # the same damping ratio
    return float(np.clip(squeeze, *SQUEEZES_M))


def _dimensions(
    states: list[mujoco.MjData], joints: tuple[str, ...], pads: tuple[str, ...], tool: str
) -> dict[str, Any]:
    """Return the hand's dimensions, by their names in `Gripper`, from its bounding boxes in several states."""
    model = states[0].model
    fingers = {int(model.geom(name).bodyid[0]) for name in pads}
    moving = with_descendants(model, *(model.joint(name).bodyid[0] for name in joints))
    hand = with_descendants(model, model.site(tool).bodyid[0]) & ~moving
    solid = [(geom, int(model.geom_bodyid[geom])) for geom in np.flatnonzero(model.geom_contype).tolist()]
    depth, finger, palm = 0.0, [], []
    for data in states:
        finger.append(np.concatenate([_box(data, geom, tool) for geom, body in solid if body in fingers]))
        inner = min(float(np.abs(_box(data, model.geom(name).id, tool)[:, 1]).min()) for name in pads)
        depth = max(depth, float(np.abs(finger[-1][:, 1]).max()) - inner)
        boxes = [_box(data, geom, tool) for geom, body in solid if hand[body] and body not in fingers]
        palm += [box for box in boxes if box[:, 2].max() < 0]
    across = max((float(np.abs(box[:, 0]).max()) for box in palm), default=0.0)
    shapes = np.concatenate(finger)
    return {
        "finger_depth_m": depth + SHAPE_MARGIN_M,
        "finger_half_width_m": float(np.abs(shapes[:, 0]).max()) + SHAPE_MARGIN_M,
        "fingertip_m": float(shapes[:, 2].max()) + SHAPE_MARGIN_M,
        "palm_height_m": -max((float(box[:, 2].max()) for box in palm), default=-USUAL_PALM_M) - SHAPE_MARGIN_M,
        "palm_half_width_m": min(across, MAX_PALM_M) + SHAPE_MARGIN_M,
    }


def _box(data: mujoco.MjData, geom: int, tool: str) -> np.ndarray:
    """Return the (8, 3) corners of a geom's bounding box in the tool's frame, m."""
    corners = box_corners(data, np.array([geom]))[0]
    return np.asarray((corners - data.site(tool).xpos) @ data.site(tool).xmat.reshape(3, 3))
