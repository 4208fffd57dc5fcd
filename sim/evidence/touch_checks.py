"""Check of what the robot and its load touch in a logged run, while its commands are simulated again.

This shares nothing with the collision checks used in motion planning (`sim.simulation.collision`).
"""

import copy
from bisect import bisect_right
from collections.abc import Sequence

import mujoco
import numpy as np

from prefplan.claims import Check
from sim.evidence.log import Log
from sim.evidence.replay import HOLD_FORCE_N, PRESS_MEMORY_FRAMES, RecordedWorld, touching

REST_TIMEOUT_S = 2.0
"""Time after a fault has moved an object during which the object may touch anything, s."""

LASTING_S = 0.5
"""Longest interruption of a contact that still counts as the same contact, s."""


class Touches:
    """The contacts of the robot, or of the current action's object, with other bodies in a simulation.

    Attributes:
        world: the recorded world.
        checked: number of states checked.
    """

    def __init__(self, log: Log, world: RecordedWorld) -> None:
        """Begin without contacts."""
        self.world, self.checked, self._log = world, 0, log
        model = self._model = copy.copy(world.mujoco)
        self._data = mujoco.MjData(model)
        self._is_robot = world.robot.bodies(model)[model.geom_bodyid]
        self._is_finger = world.robot.fingers(model)
        # The simulation ignores collisions between the robot's own links.
        world.robot.let_links_collide(model)
        # The name of each geom's body, or of the nearest ancestor with a name.
        self._names = np.array([_name_of(model, int(body)) for body in model.geom_bodyid])
        # Which geoms belong to the action's object: before the first action, when there is none, and in each action.
        self._is_load = [self._names == obj for obj in ("", *(action.obj for action in world.actions))]
        self._starts = [action.start for action in log.about.actions]
        self._of_robot = list[tuple[float, str, str]]()
        # Contacts of the objects of actions, with the action and the frame.
        self._of_load = list[tuple[tuple[float, str, str], int, int]]()

    def look(self, data: mujoco.MjData, frame: int, *, recorded: bool) -> None:
        """Add the contacts in a simulated state, at or after the frame with a number.

        If the state is `recorded` as that frame, contacts between the robot's own links count, too.
        """
        self.checked += 1
        time = float(data.time)
        if recorded:
            self._data.qpos[:], data = data.qpos, self._data
            mujoco.mj_kinematics(self._model, data)
            mujoco.mj_collision(self._model, data)
        action = bisect_right(self._starts, float(self._log.times[frame]))
        is_load = self._is_load[action]
        pairs = data.contact.geom[data.contact.dist < 0]
        for first, other in pairs[(self._is_robot | is_load)[pairs].any(axis=1)].tolist():
            if not self._is_robot[first] and (self._is_robot[other] or not is_load[first]):
                first, other = other, first
            contact = time, str(self._names[first]), str(self._names[other])
            if not self._is_robot[first]:
                self._of_load.append((contact, action - 1, frame))
            elif not (self._is_finger[first] and (self._is_finger[other] or is_load[other])):
                self._of_robot.append(contact)

    def unwanted(self) -> list[tuple[float, str, str]]:
        """Return time, s, and the names of the bodies of each unwanted contact, the one that moves first.

        The fingers may touch the object of the current action. While all pads press the object, it may touch only its
        supports and neighbours: what it touches when the pads begin or cease to press it in the action, which may set
        it down and grasp it again. While it is carried, it may touch nothing.
        """
        pressed = self.world.pad_forces.min(axis=1) > HOLD_FORCE_N
        knocks = [(knock, action) for knock, action, frame in self._of_load if pressed[frame : frame + 2].all()]
        allowed = {action: self._neighbours_in(action, pressed) for action in {action for _, action in knocks}}
        return sorted(self._of_robot + [knock for knock, action in knocks if knock[2] not in allowed[action]])

    def _neighbours_in(self, action: int, pressed: np.ndarray) -> set[str]:
        """Return what the object of an action may touch during it; `pressed` tells in which frames all pads press."""
        symbolic, log = self.world.actions[action], self._log
        found = set[str]()
        if self.world.model.operator(symbolic.kind).travels:
            return found
        is_load = self._is_load[action + 1]
        own, others = np.flatnonzero(is_load).tolist(), np.flatnonzero(~self._is_robot & ~is_load).tolist()
        during = (log.times >= self._starts[action]) & (log.times <= log.about.actions[action].end)
        frames = np.flatnonzero(during & pressed)
        begins, ceases = np.diff(frames, prepend=-np.inf), np.diff(frames, append=np.inf)
        for frame in frames[np.maximum(begins, ceases) > PRESS_MEMORY_FRAMES]:
            self._data.qpos[:] = log.qpos[frame]
            mujoco.mj_kinematics(self._model, self._data)
            touched = [other for other in others if any(touching(self._data, geom, other) for geom in own)]
            found |= {*self._names[touched].tolist()}
        return found


def check_contacts(log: Log, touches: Touches, moved: Sequence[tuple[float, str]]) -> Check:
    """Check that there was no unwanted contact, neither by the log's own events nor when it was simulated again.

    For a while after a fault has moved an object, the object may touch anything; a contact of that time is excused as
    long as it lasts. `moved` has the times, s, and objects of the faults that the states show.
    """
    events = (event for event in log.about.events if event.kind == "contact")
    told = [(event.time, str(event.detail.get("moving")), str(event.detail.get("other"))) for event in events]
    for contacts, verb, source in ((told, "touched", ", according to the log"), (touches.unwanted(), "touches", "")):
        excused = dict[tuple[str, str], float]()
        for time, moving, other in contacts:
            lasts = time - excused.get((moving, other), -np.inf) <= LASTING_S
            if lasts or any(0 <= time - start <= REST_TIMEOUT_S and obj in (moving, other) for start, obj in moved):
                excused[moving, other] = time
            else:
                return log.about.claims.against("contacts", f"{moving} {verb} {other} at {time:.2f} s{source}")
    return Check("contacts", True, f"only with the grasped object; {touches.checked} states checked")


def _name_of(model: mujoco.MjModel, body: int) -> str:
    """Return the name of a body, or of the nearest one above that has a name."""
    while not model.body(body).name:
        body = int(model.body_parentid[body])
    return str(model.body(body).name)
