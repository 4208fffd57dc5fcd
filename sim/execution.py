"""Execution: carry a plan out action by action, each confirmed by observation before the next begins."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import cast

import mujoco
import numpy as np

from prefplan.models.manipulation import ManipulationState
from prefplan.transition_system import TransitionSystem
from sim.errors import SimulationError
from sim.grounding import mismatch, observe, slot_of
from sim.rollout import Rollout, Step
from sim.scene import Scene, initial_state
from sim.skills import perform, transit
from sim.workcell import Workcell

AFTERMATH = 1.0
"""Wait after a skill that failed, s: what was dropped comes to rest before it is looked at."""


class Run:
    """A plan under way: the simulation beside the state the model predicts.

    Attributes:
        scene: what is simulated.
        system: the model's transition system.
        cell: the running simulation.
        state: index in `system` of the state that was last confirmed.
        steps: the actions carried out so far.
        reason: why it cannot go on, or None.
    """

    def __init__(self, scene: Scene, data: mujoco.MjData, *, system: TransitionSystem | None = None) -> None:
        """Begin at the model's start; a hand that starts over a location is brought there first.

        Args:
            scene: the scene.
            data: from `initial_state`; it is simulated on from there.
            system: the model's transition system, if it was built already.
        """
        self.scene = scene
        self.system = system or scene.model.transition_system()
        self.cell = Workcell(scene, data)
        self.state = self.system.start
        self.steps: list[Step] = []
        self.reason: str | None = None
        self._began = time.perf_counter()
        self._released: set[str] = set()
        if scene.model.start in scene.slots:
            transit(self.cell, scene.model.start)

    def carry_out(self, action: str) -> bool:
        """Carry out one action and compare what is observed with what the model predicts.

        Returns:
            Whether they agree; if not, `reason` says why.

        Raises:
            ModelError: the action does not exist in the present state.
        """
        target, cost = self.system.step(self.state, action)
        before, predicted = self._states(self.state), self._states(target)
        # Whoever disturbed the scene since the last action may have moved positions alone.
        mujoco.mj_forward(self.scene.mujoco, self.cell.data)
        start, spent = float(self.cell.data.time), self.cell.meter.total
        failure = None
        try:
            perform(self.cell, action)
        except SimulationError as error:
            failure = str(error)
            self.cell.wait(AFTERMATH)
        observed = self._observe(before, predicted)
        effort = self.cell.meter.total - spent
        self.steps.append(Step(action, start, float(self.cell.data.time), predicted, observed, cost, effort))
        if action.startswith("release"):
            self._released.add(action.split()[1])
        difference = mismatch(self.scene, self.cell.data, predicted=predicted, observed=observed)
        if difference or failure:
            cause = f" ({failure})" if difference and failure else ""
            self.reason = f"after `{action}`: {difference or failure}{cause}"
            self.cell.tell("mismatch", action=action, reason=self.reason)
            return False
        self.state = target
        return True

    def rollout(self) -> Rollout:
        """Return all that happened so far."""
        cell = self.cell
        return Rollout(
            completed=self.reason is None,
            reason=self.reason,
            steps=tuple(self.steps),
            events=tuple(cell.events),
            **cell.recorder.arrays,
            sim_seconds=float(cell.data.time),
            wall_seconds=time.perf_counter() - self._began,
            placement_error=self._placement_error(),
        )

    def _states(self, index: int) -> ManipulationState:
        return cast(ManipulationState, self.system.states[index])

    def _observe(self, before: ManipulationState, predicted: ManipulationState) -> ManipulationState:
        """Read the state back; a mark counts once its object is seen to rest where it was released."""
        cell = self.cell
        seen = observe(self.scene, cell.data, hand=predicted.hand, held=cell.held(), marks=before.marks)
        earned = {mark for mark in predicted.marks if seen.place.get(mark[0]) == predicted.place.get(mark[0])}
        return replace(seen, marks=before.marks | earned)

    def _placement_error(self) -> float:
        """Return the largest horizontal distance of a released object from its slot's centre, m."""
        errors = [0.0]
        for thing in self._released:
            slot = slot_of(self.scene, self.cell.data, thing)
            if slot is not None:
                errors.append(float(np.hypot(*(self.cell.data.body(thing).xpos - slot.position)[:2])))
        return max(errors)


def execute(
    scene: Scene,
    actions: Sequence[str],
    *,
    seed: int | None = None,
    system: TransitionSystem | None = None,
    on_progress: Callable[[int, int, str], None] | None = None,
) -> Rollout:
    """Carry out a plan from the model's start; stop at the first action whose outcome is not the predicted one.

    Args:
        scene: the scene.
        actions: symbolic actions, e.g. `transit top`, `grasp pink`.
        seed: None for nominal poses of the objects; otherwise they are perturbed by up to 5 mm and 5 degrees.
        system: the model's transition system, if it was built already: that takes a tenth of a rollout.
        on_progress: called before each action with how many are done, how many there are, and its name.

    Raises:
        ModelError: an action does not exist in the state in which the plan takes it; nothing is simulated then.
    """
    run = Run(scene, initial_state(scene, seed=seed), system=system)
    state = run.state
    for action in actions:
        state, _ = run.system.step(state, action)
    for done, action in enumerate(actions):
        if on_progress is not None:
            on_progress(done, len(actions), action)
        if not run.carry_out(action):
            break
    return run.rollout()
