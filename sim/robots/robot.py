"""The description of a robot: its joints, limits and gripper, and the source of its MJCF."""

from collections.abc import Callable, Iterable
from dataclasses import KW_ONLY, dataclass, field
from functools import cached_property

import mujoco
import numpy as np

from prefplan.errors import choices, prefixed
from sim.errors import RobotError
from sim.geometry.mjcf import yaw_quat
from sim.robots.gripper import Gripper

LOAD = "load at the tool"
"""Name of the body in `Robot.kinematics` that stands for what the arm bears; no object's name contains a space."""


def check_parts(spec: mujoco.MjSpec, **parts: Iterable[str]) -> None:
    """Raise RobotError unless a robot has all named parts of each kind, such as `joint`."""
    for kind, names in parts.items():
        for name in names:
            if getattr(spec, kind)(name) is None:
                known = spec.bodies if kind == "body" else getattr(spec, f"{kind}s")
                named = filter(None, (part.name for part in known))
                raise RobotError(f"no {kind} {name!r} in its MJCF {choices(name, named)}")


def always_available() -> None:
    """Return None: the robot is available on every machine."""


@dataclass(frozen=True, eq=False)
class ArmConstants:
    """Constants of an arm of n joints, from its data sheet; its base is at the origin of its MJCF and faces +x.

    Attributes:
        name: in scenarios and logs.
        joints: from base to wrist.
        velocity_limits: (n,) rad/s, m/s for a sliding joint.
        torque_limits: (n,) N m, N for a sliding joint.
        home: (n,) rad or m: the tool points down in front of the base.
        tool: site between the pads: z points out of the hand, the fingers close along y.
        acceleration_limits: (n,) rad/s^2, of planned motions; infinite if unknown.
        peak_acceleration_limits: (n,) rad/s^2, which an impact may reach; None for `acceleration_limits`.
        jerk_limits: (n,) rad/s^3; infinite if unknown.
        torque_rate_limits: (n,) N m/s; infinite if unknown.
        nearest_m: least distance of the tool from the axis of the base.
        wrist_joints: number of its wrist's joints, the last ones.
        floor_front_m: how far the base of a robot on the floor extends ahead of its axis; None for one on the table.
        title: description in words.
        payload_kg: greatest mass that it may carry, by its data sheet; None if unknown.
        unavailable_because: returns why it is not available on this machine and how to change that, or None.
        position: (3,) of its base in the scene, m.
        yaw: heading of its base in the scene, rad.
    """

    name: str
    _: KW_ONLY
    joints: tuple[str, ...]
    velocity_limits: np.ndarray
    torque_limits: np.ndarray
    home: np.ndarray
    tool: str
    acceleration_limits: np.ndarray | float = np.inf
    peak_acceleration_limits: np.ndarray | float | None = None
    jerk_limits: np.ndarray | float = np.inf
    torque_rate_limits: np.ndarray | float = np.inf
    nearest_m: float = 0.0
    wrist_joints: int = 3
    floor_front_m: float | None = None
    title: str = ""
    payload_kg: float | None = None
    unavailable_because: Callable[[], str | None] = always_available
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    yaw: float = 0.0


@dataclass(frozen=True, eq=False)
class Robot(ArmConstants):
    """A robot arm with a gripper, ready for scenes, where the table top is at z = 0.

    Its geoms have contype 2 and conaffinity 1: they collide with the world and not with each other. The defaults of its
    MJCF are in a separate class, since the main class applies to the whole scene. Position actuators have the names of
    the joints.

    Attributes:
        mjcf: module-level function that returns its MjSpec.
        base: its root body.
        gripper: its hand.
    """

    mjcf: Callable[[], mujoco.MjSpec]
    base: str
    gripper: Gripper

    @property
    def load_limits(self) -> dict[str, np.ndarray | float]:
        """The (n,) limits of the joints' loads; keys are the names of the load arrays in `sim.simulation.run.Run`."""
        peak = self.peak_acceleration_limits
        return {
            "speeds": self.velocity_limits,
            "accelerations": self.acceleration_limits if peak is None else peak,
            "jerks": self.jerk_limits,
            "torques": self.torque_limits,
            "torque_rates": self.torque_rate_limits,
        }

    def spec(self) -> mujoco.MjSpec:
        """Return the robot's MJCF, with actuators that compensate gravity within their torque limits.

        Raises `RobotError` if its MJCF cannot be loaded, or lacks a part that is named here.
        """
        gripper = self.gripper
        with prefixed(f"the robot `{self.name}` is not available here: ", RobotError):
            spec = self.mjcf()
        with prefixed(f"the robot `{self.name}` has ", RobotError):
            check_parts(
                spec,
                body=(self.base,),
                joint=(*self.joints, *gripper.joints),
                actuator=(*self.joints, gripper.actuator),
                site=(self.tool,),
                geom=gripper.pads,
            )
        for name, limit in zip(self.joints, self.torque_limits, strict=True):
            joint = spec.joint(name)
            joint.actgravcomp = True
            joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_TRUE
            joint.actfrcrange = [-limit, limit]
            # A command leads its joint, more so at high speed; clipped to the joint's range, it would cause a jerk.
            spec.actuator(name).ctrllimited = mujoco.mjtLimited.mjLIMITED_FALSE
        if self.yaw or self.position.any():
            spec.body(self.base).set_frame(spec.worldbody.add_frame(pos=self.position, quat=yaw_quat(self.yaw)))
        return spec

    def polar(self, position: np.ndarray) -> tuple[float, float]:
        """Return the distance of a point, (2,) or (3,) m, from the axis of the base, m, and its bearing, rad."""
        x, y = (np.asarray(position) - self.position[: len(position)])[:2]
        bearing = float(np.arctan2(y, x)) - self.yaw
        return float(np.hypot(x, y)), float((bearing + np.pi) % (2 * np.pi) - np.pi) if self.yaw else bearing

    @cached_property
    def kinematics(self) -> mujoco.MjModel:
        """The arm alone, without its fingers, and a point mass of 0 at its tool."""
        spec = self.spec()
        tool = spec.site(self.tool)
        load = tool.parent.add_body(name=LOAD, pos=tool.pos, ipos=np.zeros(3), explicitinertial=True)
        if tool.frame is not None:
            load.set_frame(tool.frame)
        for name in self.gripper.joints:
            joint = spec.joint(name)
            if joint is not None:  # else it was deleted with its parent finger
                spec.delete(joint.parent)
        return spec.compile()

    def bodies(self, model: mujoco.MjModel) -> np.ndarray:
        """Return (nbody,) bool: which bodies of a scene are the robot's."""
        return np.asarray(model.body_rootid == model.body(self.base).id)

    def let_links_collide(self, model: mujoco.MjModel) -> None:
        """Let MuJoCo find contacts between the robot's own links in a scene, except between a link and the next."""
        moved = self.bodies(model)
        links = moved[model.geom_bodyid] & (model.geom_contype != 0)
        model.geom_conaffinity[links] |= model.geom_contype[links]
        model.body_conaffinity[moved] |= model.body_contype[moved]

    def fingers(self, model: mujoco.MjModel) -> np.ndarray:
        """Return (ngeom,) bool: which geoms of a scene are the fingers', pads included."""
        moved = [model.joint(name).bodyid[0] for name in self.gripper.joints]
        padded = [model.geom(name).bodyid[0] for name in self.gripper.pads]
        return np.isin(model.geom_bodyid, moved + padded)

    def qpos(self, model: mujoco.MjModel) -> np.ndarray:
        """Return the (n,) indices of the arm's joints in the scene's qpos."""
        return np.array([model.joint(name).qposadr[0] for name in self.joints])

    def dofs(self, model: mujoco.MjModel) -> np.ndarray:
        """Return the (n,) indices of the arm's joints in the scene's qvel."""
        return np.array([model.joint(name).dofadr[0] for name in self.joints])

    def ranges(self, model: mujoco.MjModel) -> np.ndarray:
        """Return the (n, 2) lower and upper limits of the arm's joints, rad or m."""
        return np.array([model.joint(name).range for name in self.joints])

    def put(self, data: mujoco.MjData, q: np.ndarray, *, width: float) -> None:
        """Put the arm at (n,) joint angles and the fingers at a width between the pads, m; command both to stay."""
        for name, value in zip(self.joints, q, strict=True):
            data.joint(name).qpos[0] = data.actuator(name).ctrl[0] = value
        for name, value in zip(self.gripper.joints, self.gripper.positions(width), strict=True):
            data.joint(name).qpos[0] = value
        data.actuator(self.gripper.actuator).ctrl[0] = self.gripper.command(width)
