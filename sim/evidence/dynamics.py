"""The forces in a logged run, derived from each recorded state without stepping the simulation.

Contact forces are MuJoCo's for the recorded positions, velocities and commands. The torques of the arm are derived
twice: from its commands, by the law of its actuators, and from its motion, by inverse dynamics.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from functools import cached_property

import mujoco
import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation

from sim.errors import LogError
from sim.evidence.log import Log
from sim.evidence.replay import RecordedWorld
from sim.geometry.mjcf import columns, solid_geoms
from sim.robots.gripper import SuctionGripper
from sim.simulation.recorder import COMMANDS_PER_UNIT, STATE
from sim.world.contacts import set_margins

MAY_TOUCH_M = 0.002
"""Shapes nearer than this may touch: simulated contacts are lost and found again from step to step."""

FLIGHT_SAMPLES = 33
"""Number of poses of an object in free flight that are checked between two states: at 2 m/s they are 2 mm apart."""

SAME_STATE = 1e-6
"""Greatest difference between two states that count as equal."""

NO_RANGE = np.array([[-np.inf], [np.inf]])
"""Ends of the range of an actuator that has no limits."""


class Dynamics:
    """The recorded states of a log in order of time, and the forces in them.

    A state is a frame, or the result of an intervention. S is the number of states, F that of frames, n that of arm
    joints.

    Attributes:
        times: (S,) of each state, s.
        qpos: (S, nq) positions.
        qvel: (S, nv) velocities.
        frame: (S,) number of the frame, -1 for an intervention.
        pad_forces: (F, pads) contact forces on the gripper's pads in the step that ends in each frame, N.
        supported: by object, (S,) bool, whether anything is near enough to touch it.
        touched: by object, (S,) bool, whether the robot is.
        depth: by object, (S,) how deep it is in furniture or in another object, m.
        energy: (S,) of all objects, kinetic and potential, J.
    """

    def __init__(self, log: Log, world: RecordedWorld) -> None:
        """Derive the forces of every recorded state.

        Raises:
            LogError: the commands are not those of the robot, or an intervention is at no step.
        """
        self._log, self._world, self._model = log, world, world.mujoco
        if log.controls.shape[1] != self._model.nu:
            raise LogError(f"the log is broken: a step does not command {self._model.nu} actuators")
        # Without a step, the robot stays where it is.
        self._controls = log.controls / COMMANDS_PER_UNIT if len(log.controls) else np.zeros((1, self._model.nu))
        self._timestep = float(self._model.opt.timestep)
        self._order_states()
        self.objects = [obj for obj in world.scene.shapes if obj in log.about.joints]
        self.pad_forces = self._derive_pad_forces()
        self.supported, self.touched = (
            {obj: np.zeros(len(self.times), dtype=bool) for obj in self.objects} for _ in range(2)
        )
        self.depth = {obj: np.zeros(len(self.times)) for obj in self.objects}
        self.energy = np.sum([np.zeros(len(self.times)), *map(self._energy, self.objects)], axis=0)
        self._near = copy.copy(self._model)
        set_margins(self._near, np.full(self._near.ngeom, MAY_TOUCH_M / 2))
        self._scratch = mujoco.MjData(self._near)
        self._owner = np.full(self._model.ngeom, "", dtype=object)
        self._owner[world.robot.bodies(self._model)[self._model.geom_bodyid]] = world.robot.name
        for obj in self.objects:
            self._owner[solid_geoms(self._model, obj)] = obj
        self._gravity = np.zeros((len(self.times), len(world.robot.joints)))
        self._pressed = np.zeros((len(self.times), len(world.robot.joints)))
        self._derive_forces()

    def command(self, time: float) -> np.ndarray:
        """Return the (nu,) commands of the step that begins at a time, s."""
        row = int(round(time / self._timestep))
        found: np.ndarray = self._controls[min(row, len(self._controls) - 1)]
        return found

    def centre(self, obj: str) -> tuple[np.ndarray, np.ndarray]:
        """Return the (S, 3) positions, m, and velocities, m/s, of an object's centre of mass.

        Those of a free body in MuJoCo are of its middle, which circles about a centre of mass beside it.
        """
        offset, (pose, rates) = self._model.body(obj).ipos, columns(self._model, obj)
        position, quaternion = np.hsplit(self.qpos[:, pose], [3])
        velocity, spin = np.hsplit(self.qvel[:, rates], [3])
        turned = _turned(quaternion)
        return position + turned.apply(offset), velocity + turned.apply(np.cross(spin, offset))

    def may_meet(self, obj: str, k: int) -> Iterator[str]:
        """Yield what an object in free fall from the k-th state comes near before the next; "" is furniture.

        The robot's joints are interpolated; other objects keep their velocities and fall, too.
        """
        model, span = self._model, float(self.times[k + 1] - self.times[k])
        pose, joints = columns(model, obj)[0], model.jnt_qposadr[model.jnt_type != mujoco.mjtJoint.mjJNT_FREE]
        before, after = self.qpos[k], self.qpos[k + 1]
        centre, velocity = (rows[k] for rows in self.centre(obj))
        for share in np.linspace(0, 1, FLIGHT_SAMPLES):
            qpos, seconds = before.copy(), share * span
            mujoco.mj_integratePos(model, qpos, self.qvel[k], seconds)
            fallen = centre + velocity * seconds + model.opt.gravity * seconds**2 / 2
            qpos[pose][:3] = fallen - _turned(qpos[pose][3:]).apply(model.body(obj).ipos)
            qpos[joints] = (1 - share) * before[joints] + share * after[joints]
            for one, other in self._near_pairs(qpos):
                if one != other and obj in (one, other):
                    yield other if one == obj else one

    def _near_pairs(self, qpos: np.ndarray) -> list[list[str]]:
        """Return the owners of each two shapes that are near enough to touch at (nq,) positions; "" for furniture."""
        self._scratch.qpos[:] = qpos
        mujoco.mj_kinematics(self._near, self._scratch)
        mujoco.mj_collision(self._near, self._scratch)
        pairs: list[list[str]] = self._owner[self._scratch.contact.geom.reshape(-1, 2)].tolist()
        return pairs

    def _order_states(self) -> None:
        """Collect frames and interventions in order of time; at the same time the frame is first."""
        log, world, model = self._log, self._world, self._model
        known = log.interventions.shape[1] == 1 + mujoco.mj_stateSize(model, STATE)
        steps = log.interventions[:, :1]
        if np.any((steps < 0) | (steps > len(log.controls)) | (steps % 1 > 0)):
            raise LogError("the log is broken: an intervention is at a step that does not exist")
        data, times, qpos, qvel = mujoco.MjData(model), [*log.times], [*world.qpos], [*world.qvel]
        for row in log.interventions if known else ():
            mujoco.mj_setState(model, data, row[1:], STATE)
            # The first step begins in the first frame, unless a fault came first.
            if row[0] or not np.allclose([*data.qpos, *data.qvel], [*qpos[0], *qvel[0]], atol=SAME_STATE):
                times.append(row[0] * self._timestep)
                qpos.append(data.qpos.copy())
                qvel.append(data.qvel.copy())
        order = np.argsort(np.round(times, 6), kind="stable")
        numbers = np.concatenate([np.arange(len(log.times)), np.full(len(times) - len(log.times), -1)])
        self.frame = numbers[order]
        self.times, self.qpos, self.qvel = (np.array(rows)[order] for rows in (times, qpos, qvel))

    def _derive_pad_forces(self) -> np.ndarray:
        """Return the (F, pads) forces on the pads, N.

        A step ends in the positions that its last velocities lead to, so these lead back to where it began and found
        its contacts. Those at its end may be others: an impact is over within a step.
        """
        model, data, log = self._model, mujoco.MjData(self._model), self._log
        pads = {model.geom(name).id: i for i, name in enumerate(self._world.robot.gripper.pads)}
        forces = np.zeros((len(log.times), len(pads)))
        for k, time in enumerate(log.times):
            span = min(float(time), self._timestep)
            data.qpos[:], data.qvel[:] = self._world.qpos[k], self._world.qvel[k]
            data.ctrl[:] = self.command(time - span)
            mujoco.mj_integratePos(model, data.qpos, data.qvel, -span)
            mujoco.mj_forward(model, data)
            for i, pair in enumerate(data.contact.geom.tolist()):
                for geom in pair:
                    if geom in pads:
                        forces[k, pads[geom]] += data.efc_force[data.contact.efc_address[i]]
        return forces

    def _derive_forces(self) -> None:
        model, robot = self._model, self._world.robot
        data = mujoco.MjData(model)
        dofs = robot.dofs(model)
        for k in range(len(self.times)):
            data.qpos[:], data.qvel[:], data.ctrl[:] = self.qpos[k], self.qvel[k], self.command(self.times[k])
            mujoco.mj_forward(model, data)
            self._gravity[k] = data.qfrc_gravcomp[dofs]
            # The contact of a suction cup balances its pull, which the recorded torques do not have.
            if not isinstance(self._world.robot.gripper, SuctionGripper):
                self._pressed[k] = data.qfrc_constraint[dofs]
            owners = self._owner[data.contact.geom.reshape(-1, 2)]
            loose = (owners != robot.name).all(axis=1)
            for obj, depth in self.depth.items():
                depth[k] = -data.contact.dist[loose & (owners == obj).any(axis=1)].min(initial=0.0)
            for one, other in self._near_pairs(self.qpos[k]):
                for obj, toucher in ((one, other), (other, one)):
                    if obj in self.supported:
                        self.supported[obj][k] = True
                        self.touched[obj][k] |= toucher == robot.name

    def _energy(self, obj: str) -> np.ndarray:
        """Return the (S,) kinetic and potential energy of an object, J."""
        body, (centre, velocity) = self._model.body(obj), self.centre(obj)
        spin = self.qvel[:, columns(self._model, obj)[1]][:, 3:]
        about_axes = _turned(body.iquat).apply(spin, inverse=True)
        kinetic = (velocity**2 @ body.mass.repeat(3) + about_axes**2 @ body.inertia) / 2
        energy: np.ndarray = kinetic - centre @ self._model.opt.gravity * body.mass[0]
        return energy

    @cached_property
    def _arm(self) -> CubicHermiteSpline:
        """The (n,) angles of the arm over time: those of the frames, with the recorded velocities there."""
        robot, model, world = self._world.robot, self._model, self._world
        return CubicHermiteSpline(self._log.times, world.qpos[:, robot.qpos(model)], world.qvel[:, robot.dofs(model)])

    @cached_property
    def torques(self) -> tuple[np.ndarray, np.ndarray]:
        """Torques by the commands, N m: (F, n) greatest since the previous frame, and (F - 1, n) midway between two."""
        log, robot, model = self._log, self._world.robot, self._model
        motors = [model.actuator(name).id for name in robot.joints]
        gravity = self._gravity[self.frame >= 0]
        steps = np.rint(log.times / self._timestep).astype(int)
        last = max(1, min(int(steps[-1]), len(self._controls)))
        step = np.arange(last)
        k = (np.searchsorted(steps, step, side="right") - 1).clip(0, len(steps) - 2)
        share = ((step - steps[k]) / np.maximum(steps[k + 1] - steps[k], 1))[:, None]
        moments = step * self._timestep
        forces = _motor_forces(model, motors, self._controls[:last, motors], self._arm(moments), self._arm(moments, 1))
        forces = np.clip(
            forces + (1 - share) * gravity[k] + share * gravity[k + 1], -robot.torque_limits, robot.torque_limits
        )
        greatest, midway = np.zeros((len(steps), len(motors))), np.zeros((len(steps) - 1, len(motors)))
        np.maximum.at(greatest, k + 1, np.abs(forces))
        halfway = (steps[:-1] + steps[1:]) // 2
        midway[halfway < last] = forces[halfway[halfway < last]]
        return greatest, midway

    @cached_property
    def needed(self) -> np.ndarray:
        """The (F - 1, n) torques that the motion needs midway between frames, by inverse dynamics, N m.

        Torques due to contacts are the mean of the two frames.
        """
        model, robot, data = self._model, self._world.robot, mujoco.MjData(self._model)
        places, dofs = robot.qpos(model), robot.dofs(model)
        times = self._log.times
        halfway = (times[:-1] + times[1:]) / 2
        middle, moving = self._arm(halfway), self._arm(halfway, 1)
        speeding = np.diff(self._world.qvel[:, dofs], axis=0) / np.diff(times)[:, None]
        needed, pressed = np.zeros_like(middle), self._pressed[self.frame >= 0]
        for k in range(len(middle)):
            data.qpos[:] = self._world.qpos[k]
            data.qpos[places], data.qvel[dofs], data.qacc[dofs] = middle[k], moving[k], speeding[k]
            mujoco.mj_fwdPosition(model, data)
            mujoco.mj_fwdVelocity(model, data)
            mujoco.mj_rne(model, data, 1, data.qfrc_inverse)
            inertia = model.dof_armature * data.qacc
            needed[k] = (data.qfrc_inverse + inertia - data.qfrc_passive)[dofs] - pressed[k : k + 2].mean(axis=0)
        return needed


def _turned(quaternion: np.ndarray) -> Rotation:
    return Rotation.from_quat(quaternion, scalar_first=True)


def _motor_forces(
    model: mujoco.MjModel, motors: list[int], command: np.ndarray, q: np.ndarray, v: np.ndarray
) -> np.ndarray:
    """Return the forces of position actuators from commands, positions and velocities of their joints."""
    bias = model.actuator_biasprm[motors]
    command = np.clip(
        command, *np.where(model.actuator_ctrllimited[motors], model.actuator_ctrlrange[motors].T, NO_RANGE)
    )
    forces = model.actuator_gainprm[motors, 0] * command + bias[:, 0] + bias[:, 1] * q + bias[:, 2] * v
    low, high = np.where(model.actuator_forcelimited[motors], model.actuator_forcerange[motors].T, NO_RANGE)
    return np.clip(forces, low, high)
