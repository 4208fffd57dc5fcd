"""Execution of a plan, action by action; each is confirmed by an observation before the next one begins."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, cast

import mujoco
import numpy as np

from prefplan.errors import ModelError, choices
from prefplan.models.manipulation.model import ManipulationState
from prefplan.models.manipulation.symbolic import Action, at
from prefplan.models.system import System
from sim.capability.graspable import ungraspable_because
from sim.capability.rehearsal import BROUGHT, Rehearsal, bringing, culprits, unable_to_begin
from sim.errors import BlockedError, SimulationError
from sim.execution.faults.fault import Fault
from sim.execution.faults.injector import FaultInjector
from sim.execution.observation import await_grip, settled_poses
from sim.perception.grounding import mismatch, observe, present_marks, slot_of
from sim.perception.sensors import ObservationTimeoutError, Poses, Sensor, true_poses
from sim.perception.world_model import reground
from sim.simulation.kinematic_cell import KinematicCell
from sim.simulation.run import Run, Step
from sim.simulation.workcell import Workcell
from sim.skills.catalogue import SKILLS, perform
from sim.skills.skill import Skill, SkillError
from sim.world.scene import Scene, initial_state

SETTLE_AFTER_FAILURE_S = 1.0
"""Wait after a failed skill, s: an object that was dropped comes to rest before it is observed."""


class Execution:
    """The execution of a plan: the simulation, and the state predicted by the model.

    Attributes:
        scene: the simulated scene, with the model grounded in the last observation.
        system: the model's transition system.
        cell: the running simulation.
        state: the last confirmed state, a state of `system`.
        predicted: the state of `system` predicted after the last action.
        steps: the actions carried out so far.
        reason: how the last observation differs from the prediction, or None.
        lost_sensor: whether an observation timed out, which ends the execution.
        blocked: names of the bodies that blocked the last action, which fails again unless an object moves; empty if
            its goal was out of reach; None if the action may succeed when it is tried again.
        hindering: objects that made the last action fail, found by a rehearsal; empty if unknown.
        lost: the reason why the arm cannot grasp an object, by the object's name.
        injector: injects the faults.
    """

    def __init__(
        self,
        scene: Scene,
        data: mujoco.MjData,
        *,
        system: System | None = None,
        sensor: Sensor | None = None,
        skills: Mapping[str, Skill] = SKILLS,
        faults: Sequence[Fault] = (),
        seed: int | None = None,
    ) -> None:
        """Begin at the model's start; if the hand starts over a location, it is moved there first.

        `data` is from `initial_state`; `skills` are by kind of action. Without `system`, the model's transition system
        is built, which takes a tenth of the time of a run; without `sensor`, observed poses are exact. `seed`, 0 for
        None, determines the faults' random numbers and the motion planner's.

        Raises:
            SimulationError: a kind of action of the model has no skill, or the hand cannot reach its start.
        """
        for kind in scene.model.kinds:
            if kind not in skills:
                raise SimulationError(f"skills: none for {kind!r} {choices(kind, skills)}")
        self.scene = self._built = scene
        self.system = system or scene.model.transition_system()
        self.cell = Workcell(scene, data, sensor=sensor, seed=seed or 0)
        self._skills = dict(skills)
        self.state = self.predicted = self.system.start
        self.steps: list[Step] = []
        self.reason: str | None = None
        self.lost_sensor = False
        self.blocked: tuple[str, ...] | None = None
        self.hindering: tuple[str, ...] = ()
        self.lost: Mapping[str, str] = {}
        self.injector = FaultInjector(self.cell, self._skills, faults, seed=seed)
        self._began = time.perf_counter()
        self._placed: set[str] = set()
        if scene.model.start in scene.slots:
            try:
                perform(self.cell, Action("transit", location=scene.model.start), self._skills)
            except SimulationError as error:
                raise SimulationError(unable_to_begin(scene, error)) from None

    def check_state(self, *, at_rest: bool = False) -> bool:
        """Return whether an observation agrees with the current state; if not, `reason` says why.

        With `at_rest`, objects come to rest first; one that does not is a mismatch.
        """
        state = self._states(self.state)
        try:
            poses, moving = settled_poses(self.cell, at_rest=at_rest)
            seen = observe(self.scene, self.cell.data, poses, hand=state.hand, held=self.cell.held(), marks=state.marks)
            self.reason = mismatch(self.scene, poses, predicted=state, observed=seen)
            if at_rest and moving and self.reason is None:
                self.reason = f"{moving[0]} does not come to rest"
            if at_rest and self.reason is None and self.steps:
                self.steps[-1] = replace(self.steps[-1], observed=seen, end=float(self.cell.data.time))
        except ObservationTimeoutError as error:
            self.reason, self.lost_sensor = str(error), True
        if self.reason is not None and self.steps:
            self.cell.log_event("mismatch", action=self.steps[-1].action, reason=self.reason)
        return self.reason is None

    def step(self, action: str, *, ahead: Sequence[str] = ()) -> bool:
        """Carry out one action, and return whether the observed state is the predicted one; if not, `reason` says why.

        `ahead` are the actions after it: an object is grasped so that it can be released at its next location.

        Raises:
            ModelError: the action is not applicable in the current state.
        """
        target, cost = self.system.step(self.state, action)
        self.predicted = target
        before, predicted = self._states(self.state), self._states(target)
        symbolic = self.scene.model.action(action)
        # If a fault has moved objects since the last action, derived quantities are out of date.
        mujoco.mj_forward(self.scene.mujoco, self.cell.data)
        start, spent = float(self.cell.data.time), self.cell.effort
        self.injector.begin(len(self.steps) + 1)
        failure = difference = None
        observed = before
        try:
            failure = self._attempt(symbolic, predicted.held, [self.scene.model.action(text) for text in ahead])
            poses, _ = settled_poses(self.cell, at_rest=False)
            observed = self._observe(poses, before, predicted, done=failure is None)
            difference = mismatch(self.scene, poses, predicted=predicted, observed=observed)
        except ObservationTimeoutError as error:
            failure, self.lost_sensor = str(error), True
        effort = self.cell.effort - spent
        self.steps.append(Step(action, start, float(self.cell.data.time), predicted, observed, cost, effort))
        if at(symbolic.obj, symbolic.location) in self.scene.model.effect(symbolic):
            self._placed.add(symbolic.obj)
        if difference or failure:
            cause = f" ({failure})" if difference and failure else ""
            self.reason = f"after `{action}`: {difference or failure}{cause}"
            self.cell.log_event("mismatch", action=action, reason=self.reason)
            self.cell.settle()
            return False
        self.state, self.reason = target, None
        return True

    def reground(self) -> ManipulationState:
        """Ground the current state in an observation, extend the model so that it has this state, and return the state.

        Waits until objects are at rest. The state becomes the observed one of the last step.

        Raises:
            ObservationTimeoutError: an object is not observed for too long.
        """
        cell = self.cell
        marks = self.steps[-1].observed.marks if self.steps else self._states(self.state).marks
        hand = self.steps[-1].predicted.hand if self.steps else self._states(self.state).hand
        poses, _ = settled_poses(cell, at_rest=True)
        lost = partial(ungraspable_because, cell)
        self.scene, self.lost = reground(
            self._built, cell.data, poses, hand=hand, held=cell.held(), marks=marks, lost_because=lost
        )
        cell.scene, state = self.scene, self.scene.model.initial_state
        if self.steps:
            self.steps[-1] = replace(self.steps[-1], observed=state, end=float(cell.data.time))
        return state

    def go_on(self, system: System) -> None:
        """Continue in another transition system, which starts in the current state."""
        self.system, self.reason = system, None
        self.state = self.predicted = system.start

    def record(self) -> Run:
        """Return the record of the run so far, after the arm has come to rest."""
        cell = self.cell
        cell.settle()
        frames: dict[str, Any] = cell.recorder.arrays
        loads = {name: frames.pop(name) for name in self.scene.robot.load_limits}
        run = Run(
            reason=self.reason,
            steps=tuple(self.steps),
            events=tuple(cell.events),
            **frames,
            loads=loads,
            sim_seconds=float(cell.data.time),
            wall_seconds=time.perf_counter() - self._began,
            placement_error=self._placement_error(),
            robot=self.scene.robot,
        )
        return replace(run, reason=run.reason or run.objection)

    def _states(self, state: Any) -> ManipulationState:
        return cast(ManipulationState, self.system.decode(state))

    def _attempt(self, action: Action, held: str | None, ahead: Sequence[Action]) -> str | None:
        """Perform an action, and check that the hand then holds an object, if given; return why it failed, or None."""
        self.blocked, self.hindering = None, ()
        try:
            self._skills[action.kind].perform(self.cell, action, ahead)
            await_grip(self.cell)
            if held is not None and self.cell.held() != held:
                raise SkillError(f"{held} slipped from the hand")
        except ObservationTimeoutError:
            raise
        except SimulationError as error:
            if isinstance(error, BlockedError):
                self.blocked = error.by
            elif not isinstance(error, SkillError):
                self.blocked = ()
            if self.blocked is not None:
                self.hindering = self._hindering(action, ahead)
            self.cell.wait(SETTLE_AFTER_FAILURE_S)
            return str(error)
        return None

    def _hindering(self, action: Action, ahead: Sequence[Action]) -> tuple[str, ...]:
        """Return the objects that make an action fail, found by rehearsals; none if these add nothing to the error.

        The first is the object that the action moves or moves to. The others are those without any one of which the
        action succeeds; there are none if it fails even without all of them (a transit: from home, too).
        """
        before, obj = self._states(self.state), action.obj
        via = before.hand if before.hand in self.scene.slots else ""
        others = (self.scene.shapes.keys() & (self.blocked or ())) - {obj}
        if action.kind == "transport" and via and others:
            return () if self.can_bring(before, obj, via, action.location) else (obj,)
        if action.kind == "transport" and via:
            failing = bringing(obj, via, action.location, before.place).beginning(BROUGHT)
        elif action.kind == "transit" and ahead and ahead[0].kind == "grasp":
            obj = ahead[0].obj
            failing = Rehearsal((str(action), str(ahead[0])), before.place, obj, action.location, via)
        else:
            return ()
        try:
            scene = self._as_observed(before)
            cell = KinematicCell(scene, initial_state(scene))
            found = culprits(failing, cell, scene, self._skills)
            if found == [] and action.kind == "transit":
                from_home = replace(failing, via="").alone(scene.model)
                found = None if from_home.run(cell, scene, self._skills)[1] is None else found
        except (ModelError, SimulationError):  # something lies off every location, or where there is no room for it
            return ()
        return () if found is None else (obj, *found)

    def can_bring(self, state: ManipulationState, obj: str, source: str, location: str) -> bool:
        """Return whether a rehearsal without other objects brings an object from one location to another."""
        try:
            scene = self._as_observed(state)
            alone = bringing(obj, source, location, state.place).beginning(BROUGHT).alone(scene.model)
            return alone.run(KinematicCell(scene, initial_state(scene)), scene, self._skills)[1] is None
        except (ModelError, SimulationError):
            return True

    def _as_observed(self, state: ManipulationState) -> Scene:
        """Return the scene with each location of one slot moved to the observed pose of the object that rests there."""
        slots = dict(self.scene.slots)
        for obj, place in state.places:
            if len(slots[place]) == 1:
                pose, slot = self.cell.observe(obj), slots[place][0]
                at = np.append(pose.position[:2], slot.position[2])
                slots[place] = (replace(slot, position=at, yaw=pose.shape.yaw_near(pose.yaw, slot.yaw)),)
        return replace(self.scene, slots=slots)

    def _observe(
        self, poses: Poses, before: ManipulationState, predicted: ManipulationState, *, done: bool
    ) -> ManipulationState:
        """Ground the state in observed poses; a new mark counts only if its object rests where it was released."""
        cell = self.cell
        seen = observe(self.scene, cell.data, poses, hand=predicted.hand, held=cell.held(), marks=before.marks)
        earned = {mark for mark in predicted.marks if seen.place.get(mark[0]) == predicted.place.get(mark[0])}
        return replace(seen, marks=seen.marks | present_marks(frozenset(earned), poses)) if done else seen

    def _placement_error(self) -> float:
        """Return the largest horizontal distance of a placed object from its slot's centre, m."""
        # `poses` lacks objects that fell from the table.
        poses = true_poses(self.scene, self.cell.data)
        placed = self._placed & poses.keys()
        slots = {obj: slot for obj in placed if (slot := slot_of(self.scene, poses, obj)) is not None}
        errors = (float(np.hypot(*(poses[obj].position - slot.position)[:2])) for obj, slot in slots.items())
        return max(errors, default=0.0)


def execute(
    scene: Scene,
    actions: Sequence[str],
    *,
    seed: int | None = None,
    system: System | None = None,
    skills: Mapping[str, Skill] = SKILLS,
    on_progress: Callable[[int, int, str], None] | None = None,
) -> Run:
    """Carry out a plan from the model's start; stop at the first action whose outcome is not the predicted one.

    Actions are such as `transit top`, `grasp pink`. With a seed, objects are off their nominal poses by up to 5 mm and
    5 degrees. System and skills are as for `Execution`. `on_progress` is called before each action with the number of
    actions done, the number of all actions, and the action's name.

    Raises:
        ModelError: an action is not applicable in its state; nothing is simulated then.
    """
    run = Execution(scene, initial_state(scene, seed=seed), system=system, skills=skills)
    run.system.trajectory(actions)
    for done, action in enumerate(actions):
        if on_progress is not None:
            on_progress(done, len(actions), action)
        if not run.step(action, ahead=actions[done + 1 :]):
            break
    return run.record()
