"""Closed loop: a plan is executed, and planned again where an observation affects what is left of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import cast

from prefplan.errors import ModelError, PrefplanError
from prefplan.exact_costs import Number
from prefplan.front import NoPlanError, Plan
from prefplan.ledger import Label
from prefplan.models.manipulation.action import at, holding
from prefplan.models.manipulation.model import ManipulationState
from prefplan.models.transition_system import TransitionSystem
from prefplan.problem import Problem
from prefplan.replanning import Past, achievable, damaged, violated
from sim.execution.executor import Execution
from sim.perception.sensors import ObservationTimeoutError

MAX_ATTEMPTS = 3
"""An action that leads to the same unexpected state this often is given up."""

MAX_REPLANS = 10
"""New plans in one execution."""

GoOn = Callable[[Problem, Past, TransitionSystem], Plan]
"""Returns the plan to follow, which begins with the past; raises NoPlanError if there is none."""


@dataclass(frozen=True)
class Pursuit:
    """How the pursuit of a plan ended.

    Attributes:
        plan: the one that was followed last; its actions are what was carried out if it was completed.
        replans: how many times another plan was made.
        retries: how many times an action was tried again as it was.
        violated: tasks that can no longer be satisfied after what happened.
    """

    plan: Plan
    replans: int = 0
    retries: int = 0
    violated: tuple[str, ...] = ()


class _GivenUp(Exception):
    """The pursuit ends without success; the message says why."""


class ClosedLoop:
    """The pursuit of a plan.

    Attributes:
        run: the execution.
        plan: the one followed at present.
    """

    def __init__(
        self,
        run: Execution,
        problem: Problem,
        plan: Plan,
        *,
        go_on: GoOn,
        on_progress: Callable[[int, int, str], None] = lambda done, total, action: None,
    ) -> None:
        """Pursue a plan.

        Args:
            run: an execution at its start.
            problem: what was planned.
            plan: one of its plans.
            go_on: returns the plan to follow after a mismatch, e.g. `prefplan.replanning.continue_cheaply`.
            on_progress: called before each action with the number of actions done, that of all actions, and its name.
        """
        self.run, self.plan = run, plan
        self._problem, self._go_on, self._on_progress = problem, go_on, on_progress
        self._states: list[ManipulationState] = [cast(ManipulationState, problem.system.states[problem.system.start])]
        self._replans = self._retries = 0
        self._attempts: Counter[tuple[str, ManipulationState]] = Counter()
        self._barred: set[tuple[frozenset[str], str]] = set()

    @property
    def pursuit(self) -> Pursuit:
        """The result up to now."""
        return Pursuit(self.plan, self._replans, self._retries, violated(self._problem, self._labels))

    @property
    def _labels(self) -> list[frozenset[str]]:
        return [state.label for state in self._states]

    def pursue(self) -> None:
        """Execute the plan until it is completed or given up; then `run.reason` says why."""
        try:
            if not self.run.check_state():
                self._replan()
            while not self._is_completed():
                done = len(self.run.steps)
                action = self.plan.actions[done]
                self._on_progress(done, len(self.plan.actions), action)
                if self.run.step(action, ahead=self.plan.actions[done + 1 :]):
                    self._states.append(self.run.steps[-1].observed)
                else:
                    self._replan()
            self._on_progress(len(self.plan.actions), len(self.plan.actions), "")
        except _GivenUp as end:
            self.run.reason = str(end)
            self.run.cell.log_event("ended", reason=str(end))

    def _is_completed(self) -> bool:
        """Return whether the plan is carried out, and nothing moves any more where the model says that it is."""
        for _ in range(MAX_REPLANS):
            if len(self.run.steps) < len(self.plan.actions):
                return False
            if self.run.check_state(at_rest=True):
                return True
            surprise = self.run.reason
            self._replan()
        raise _GivenUp(surprise)

    def _replan(self) -> None:
        """Ground the present state in an observation, and follow the best plan from there.

        A plan of which nothing that is left is affected is followed on.

        Raises:
            _GivenUp: there is no plan, or too many were made.
        """
        run, surprise = self.run, self.run.reason or ""
        if run.lost_sensor:
            raise _GivenUp(surprise)
        try:
            state = run.reground()
        except ObservationTimeoutError as error:
            raise _GivenUp(f"{surprise}; {error}") from None
        self._record_failure(state)
        try:
            system = run.scene.model.transition_system().without(self._barred)
        except PrefplanError as error:
            raise _GivenUp(f"{surprise}; no plan can be made: {error}") from None
        if self._is_unaffected(system):
            run.cell.log_event("unaffected", reason=surprise)
            run.go_on(system)
            return
        ahead = self.plan.actions[max(len(run.steps) - 1, 0) :]
        past = self._past()
        try:
            self.plan = self._go_on(self._problem, past, system)
        except NoPlanError as error:
            raise _GivenUp(self._why_no_plan(surprise, past, system, error)) from None
        except PrefplanError as error:
            raise _GivenUp(f"{surprise}; no plan can be made: {error}") from None
        actions = self.plan.actions[len(run.steps) :]
        if actions and self._replans >= MAX_REPLANS:
            raise _GivenUp(f"given up after {MAX_REPLANS} new plans, {surprise}")
        run.go_on(system)
        if actions == ahead:
            self._retries += 1
            run.cell.log_event("retry", action=ahead[0], reason=surprise)
            return
        self._replans += 1
        detail = {"reason": surprise, "plan": list(actions), "cost": self.plan.cost, "preference": self.plan.preference}
        if broken := damaged(self._problem, self._labels):
            detail["violated"] = list(broken)
        run.cell.log_event("replan", **detail)

    def _record_failure(self, state: ManipulationState) -> None:
        """Record the present state; bar an action that was blocked, or failed repeatedly without a change of state."""
        steps = self.run.steps
        if not steps:
            self._states = [state]
            return
        action = steps[-1].action
        self._attempts[action, state] += 1
        if self._attempts[action, state] >= MAX_ATTEMPTS or self.run.blocked is not None:
            self._barred |= {(self._conditions_of_failure(s, action), action) for s in (self._states[-1], state)}
        self._states[len(steps) :] = [state]

    def _is_unaffected(self, system: TransitionSystem) -> bool:
        """Return whether the rest of the plan does to the tasks in a new model what it was to do in the present one."""
        run = self.run
        rest = self.plan.actions[len(run.steps) :]
        try:
            return self._trace(system, system.start, rest) == self._trace(run.system, run.predicted, rest)
        except ModelError:
            return False

    def _trace(self, system: TransitionSystem, state: int, actions: Sequence[str]) -> list[tuple[Label, Number]]:
        """Return what the tasks see before each of some actions, and its cost; and what they see at the end.

        Raises:
            ModelError: an action does not exist.
        """
        trace = []
        for action in actions:
            label = system.label(state) & self._problem.task_propositions
            state, cost = system.step(state, action)
            trace.append((label, cost))
        return [*trace, (system.label(state) & self._problem.task_propositions, 0)]

    def _conditions_of_failure(self, state: ManipulationState, action: str) -> frozenset[str]:
        """Return the propositions under which an action that failed would fail again.

        An action that another object blocks is barred until an object moves. One that a fixture blocks, or whose goal
        is out of reach, is barred until its own object moves. A transit has no object, and its path depends on how
        high the objects are piled up: it is barred until any object moves, or if a fixture keeps the hand from where
        an object lies off every location, until that one does.
        """
        symbolic, blocked = self.run.scene.model.action(action), self.run.blocked
        obj = symbolic.obj
        if not obj and symbolic.location in self.run.scene.temporary:
            obj = next((name for name, place in state.place.items() if place == symbolic.location), "")
        if not obj or blocked is None or any(name in self.run.scene.shapes for name in blocked):
            return state.label
        return state.label & {holding(obj), at(obj, state.place.get(obj, ""))} or state.label

    def _past(self) -> Past:
        """Return the executed actions, and the observed state before each of them."""
        steps = self.run.steps
        before = self._states[: len(steps)]
        return Past(
            tuple(step.action for step in steps),
            tuple(step.cost for step in steps),
            tuple(before),
            tuple(state.label for state in before),
        )

    def _why_no_plan(self, surprise: str, past: Past, system: TransitionSystem, error: NoPlanError) -> str:
        """Return why there is no plan any more, and what could still be achieved, in a sentence."""
        why = [surprise]
        if broken := violated(self._problem, self._labels):
            why.append(f"{' and '.join(broken)} {'is' if len(broken) == 1 else 'are'} violated beyond repair")
        elif max(self._attempts.values(), default=0) >= MAX_ATTEMPTS:
            why.append(f"given up after {MAX_ATTEMPTS} attempts")
        elif self._barred:
            why.append("there is no way round it")
        else:
            why.append(str(error.reason))
        why += [f"{obj} {reason}" for obj, reason in self.run.lost.items()]
        rest = achievable(self._problem, past, system)
        if rest is not None and rest.task_costs:
            skipped = {bought.task for bought in rest.relaxations if bought.assume is None}
            ends = {"satisfied": rest.task_costs.keys() - skipped, "skipped": rest.task_costs.keys() & skipped}
            words = [
                f"{' and '.join(name for name in rest.task_costs if name in names)} could still be {end}"
                for end, names in ends.items()
                if names
            ]
            why.append(f"{' and '.join(words)}, at a total cost of {rest.cost}")
        return "; ".join(why)
