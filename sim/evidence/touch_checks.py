"""Check of what the robot and its load touch in a log, frame by frame and in between.

This shares nothing with the collision checks used in motion planning (`sim.simulation.collision`).
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from prefplan.claims import Check
from sim.evidence.log import Log, LoggedAction
from sim.evidence.replay import HOLD_FORCE_N, RecordedWorld, fault_of, touching
from sim.simulation.run import FRAME_RATE_HZ, Event

MAX_GAP_M = 0.005
"""Greatest distance that a point of the robot moves between two states that are checked."""

INTERPOLATION_ERROR_M = 0.0005
"""States between frames are interpolated: there, contacts less deep than this do not count."""

MOST_BETWEEN = 20
"""Greatest number of intervals between two frames: an arm within its speed limits needs fewer."""

REST_TIMEOUT_S = 2.0
"""For this long after a fault has moved an object, it may touch anything."""


def check_contacts(log: Log, world: RecordedWorld, faults: Sequence[Event]) -> Check:
    """Check every frame, and states in between wherever the robot moves by more than `MAX_GAP_M`, for touches.

    The fingers may touch the object of the current action. While both pads press it, the object may touch what it
    touches when they first or last press it in the action: its supports and neighbours. While it is carried, it may
    touch nothing. An object that a fault has just moved may touch anything.

    Args:
        log: of the run.
        world: rebuilt from it.
        faults: from `shown_faults`.
    """
    name = "contacts"
    for event in log.about.events:
        touched = set(map(str, event.detail.values()))
        if event.kind == "contact" and touched.isdisjoint(_disturbed(log, world, faults, event.time)):
            words = f"{event.detail.get('moving')} touched {event.detail.get('other')} at {event.time:.2f} s"
            return log.about.claims.against(name, f"{words}, according to the log")
    touches, checked = _Touches(log, world), 0
    for frame, share in _moments(log, world):
        checked += 1
        found = touches.unwanted(frame, share)
        if found:
            time = float(log.times[frame] + (share * (log.times[frame + 1] - log.times[frame]) if share else 0.0))
            found = [pair for pair in found if _disturbed(log, world, faults, time).isdisjoint(pair)]
        if found:
            moving, other = found[0]
            return log.about.claims.against(name, f"{moving} touches {other} at {time:.2f} s")
    return Check(name, True, f"only with the grasped object; {checked} states checked, with {world.arm_shapes}")


def _disturbed(log: Log, world: RecordedWorld, faults: Sequence[Event], time: float) -> set[str]:
    """Return the objects that faults have moved, knocked over or let slip within `REST_TIMEOUT_S` before a time."""
    disturbed: set[str] = set()
    for event in faults:
        if 0 <= time - event.time <= REST_TIMEOUT_S:
            disturbed |= set(world.disturbed(event))
            action = _action_at(log, event.time)
            symbolic = action and world.action(action.action)
            if fault_of(event)[0] == "slip" and symbolic:
                disturbed.add(symbolic.obj)
    return disturbed - {""}


def _action_at(log: Log, time: float) -> LoggedAction | None:
    """Return the action at a time, or the one before it."""
    begun = [action for action in log.about.actions if action.start <= time]
    return begun[-1] if begun else None


def _moments(log: Log, world: RecordedWorld) -> Iterator[tuple[int, float]]:
    """Yield each frame with 0, and with the shares of the time to the next frame at which to check in between.

    Where frames are missing, or something was moved from outside, the states in between are unknown.
    """
    period = np.diff(log.times)
    steps = np.rint(log.interventions[:, 0] * world.mujoco.opt.timestep * 1e6) / 1e6
    unknown = (period <= 0) | (period > 1.5 / FRAME_RATE_HZ)
    unknown |= np.searchsorted(steps, log.times[1:]) > np.searchsorted(steps, log.times[:-1])
    model, data = world.mujoco, mujoco.MjData(world.mujoco)
    shapes = np.flatnonzero(world.robot.bodies(model)[model.geom_bodyid] & (model.geom_contype != 0))

    def corners(frame: int) -> np.ndarray:
        data.qpos[:] = world.qpos[frame]
        mujoco.mj_kinematics(model, data)
        axes = data.geom_xmat[shapes].reshape(-1, 3, 3).transpose(0, 2, 1)
        return data.geom_xpos[shapes][:, None] + model.geom_rbound[shapes][:, None, None] * axes

    ahead = corners(0)
    for frame in range(len(log.times)):
        yield frame, 0.0
        if frame + 1 == len(log.times):
            break
        here, ahead = ahead, corners(frame + 1)
        gaps = np.linalg.norm(ahead - here, axis=2).max() / MAX_GAP_M
        parts = 1 if unknown[frame] else min(MOST_BETWEEN, int(np.ceil(gaps)))
        for part in range(1, parts):
            yield frame, part / parts


class _Touches:
    """The scene of a log, in which contacts are detected."""

    def __init__(self, log: Log, world: RecordedWorld) -> None:
        self._log, self._world = log, world
        model = self._model = copy.copy(world.mujoco)
        self._data = mujoco.MjData(model)
        self._is_robot = world.robot.bodies(model)[model.geom_bodyid]
        self._is_finger = world.robot.fingers(model)
        # The simulation ignores collisions between the robot's own links.
        world.robot.let_links_collide(model)
        self._owner = np.array([_name(model, int(body)) for body in model.geom_bodyid], dtype=object)
        self._neighbours: dict[LoggedAction, set[str]] = {}

    def unwanted(self, frame: int, share: float) -> list[tuple[str, str]]:
        """Return names of bodies in unwanted contact: one of the robot or the load, and another.

        Args:
            frame: number of the frame at or before the state.
            share: of the time to the next frame.
        """
        log = self._log
        pairs = self._contacts(frame, share)
        action = _action_at(log, float(log.times[frame]))
        symbolic = action and self._world.action(action.action)
        obj = symbolic.obj if symbolic else ""
        is_robot, is_load = self._is_robot[pairs], (self._owner[pairs] == obj) & (obj != "")
        wanted = (self._is_finger[pairs] | is_load).all(axis=1)
        found = self._named(pairs[is_robot.any(axis=1) & ~wanted], self._is_robot)
        knocks = is_load.any(axis=1) & ~is_robot.any(axis=1)
        held = bool(log.pad_forces[frame : frame + (2 if share else 1)].min() > HOLD_FORCE_N)
        if action and symbolic and held and knocks.any():
            carried = self._world.model.operator(symbolic.kind).travels
            allowed = set() if carried else self._neighbours_of(obj, action)
            found += [pair for pair in self._named(pairs[knocks], self._owner == obj) if pair[1] not in allowed]
        return found

    def _contacts(self, frame: int, share: float) -> np.ndarray:
        """Return the (K, 2) pairs of geoms that touch in a state."""
        data, deep = self._data, INTERPOLATION_ERROR_M if share else 0.0
        data.qpos[:] = self._between(frame, share) if share else self._world.qpos[frame]
        mujoco.mj_kinematics(self._model, data)
        mujoco.mj_collision(self._model, data)
        return np.asarray(data.contact.geom.reshape(-1, 2)[data.contact.dist < -deep])

    def _between(self, frame: int, share: float) -> np.ndarray:
        """Return the (nq,) positions between two frames, by cubic Hermite interpolation."""
        world, model = self._world, self._model
        span = float(self._log.times[frame + 1] - self._log.times[frame])
        change, now = np.empty(model.nv), world.qpos[frame].copy()
        mujoco.mj_differentiatePos(model, change, 1.0, now, world.qpos[frame + 1])
        v0, v1 = span * world.qvel[frame], span * world.qvel[frame + 1]
        moved = v0 * share + (3 * change - 2 * v0 - v1) * share**2 + (v0 + v1 - 2 * change) * share**3
        mujoco.mj_integratePos(model, now, moved, 1.0)
        return now

    def _neighbours_of(self, obj: str, action: LoggedAction) -> set[str]:
        """Return the names of what an object touches when the pads first and last press it in an action."""
        if action not in self._neighbours:
            model, data, found = self._model, self._data, set[str]()
            own = np.flatnonzero(self._owner == obj).tolist()
            others = np.flatnonzero(~self._is_robot & (self._owner != obj)).tolist()
            log = self._log
            during = (log.times >= action.start) & (log.times <= action.end)
            pressed = np.flatnonzero(during & (log.pad_forces.min(axis=1) > HOLD_FORCE_N))
            for frame in pressed[[0, -1]] if len(pressed) else ():
                data.qpos[:] = self._world.qpos[frame]
                mujoco.mj_kinematics(model, data)
                found |= {self._owner[other] for other in others for geom in own if touching(data, geom, other)}
            self._neighbours[action] = found
        return self._neighbours[action]

    def _named(self, pairs: np.ndarray, moves: np.ndarray) -> list[tuple[str, str]]:
        """Return the names of the bodies of (K, 2) geoms, with the one that moves in front."""
        ordered = [(a, b) if moves[a] else (b, a) for a, b in pairs]
        return [(str(self._owner[a]), str(self._owner[b])) for a, b in ordered]


def _name(model: mujoco.MjModel, body: int) -> str:
    """Return the name of a body, or of the nearest one above that has one."""
    while not model.body(body).name:
        body = int(model.body_parentid[body])
    return str(model.body(body).name)
