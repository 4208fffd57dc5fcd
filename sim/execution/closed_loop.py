"""Closed loop: a plan is executed, and planned again where an observation affects what is left of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import cast

from prefplan.errors import ModelError, PrefplanError
from prefplan.exact_costs import Number
from prefplan.front import NoPlanError, Plan
from prefplan.logic.good_prefix import Label
from prefplan.models.manipulation.model import ManipulationState
from prefplan.models.transition_system import TransitionSystem
from prefplan.problem import Problem, Task
from prefplan.replanning import Past, achievable, continue_cheaply, damaged, sparing, spoiled, valued, violated
from sim.execution.executor import Execution
from sim.execution.failures import MAX_ATTEMPTS, Failures
from sim.perception.sensors import ObservationTimeoutError

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
        # What is still pursued, and why that is not all of the problem.
        self._goal = problem
        self._shortfalls: list[str] = []
        self._states: list[ManipulationState] = [cast(ManipulationState, problem.system.states[problem.system.start])]
        self._replans = self._retries = 0
        self._failures = Failures()

    @property
    def pursuit(self) -> Pursuit:
        """The result up to now."""
        return Pursuit(self.plan, self._replans, self._retries, violated(self._problem, self._labels))

    @property
    def _labels(self) -> list[frozenset[str]]:
        return [state.label for state in self._states]

    def pursue(self) -> None:
        """Execute the plan until it is completed or given up; then `run.reason` says why.

        Where not all tasks can be done any more, those are that can without making one of the others impossible.
        """
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
            self._shortfalls.append(str(end))
        if self._shortfalls:
            self.run.reason = "; ".join(self._shortfalls)
            self.run.cell.log_event("ended", reason=self.run.reason)

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
        if run.steps:
            self._failures.record(run, self._problem, self._states)
        self._states[len(run.steps) :] = [state]
        ahead = self.plan.actions[max(len(run.steps) - 1, 0) :]
        try:
            system = self._system()
            if self._is_unaffected(system):
                run.cell.log_event("unaffected", reason=surprise)
                run.go_on(system)
                return
            surprise, system = self._plan_on(surprise, system)
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

    def _system(self) -> TransitionSystem:
        """Return the model from the present state on, without what has failed."""
        return self.run.scene.model.transition_system().without(self._failures.barred)

    def _plan_on(self, surprise: str, system: TransitionSystem) -> tuple[str, TransitionSystem]:
        """Plan from here on in a model; return what led to that plan, and the model that it is of.

        Raises:
            PrefplanError: no plan can be made.
            _GivenUp: nothing is left to do.
        """
        past, labels = self._past(), self._labels
        problem = self._failures.with_detours(sparing(self._goal, self._left_out(self._goal), labels), labels)
        try:
            plan = self._go_on(problem, past, system)
        except NoPlanError as error:
            if self._failures.bar_detours():
                return self._plan_on(surprise, self._system())
            surprise = self._why_no_plan(surprise, error)
            self._leave_tasks_out(surprise, past, system)
            return surprise, system
        self.plan = self._worth(plan, past, system)
        return surprise, system

    def _left_out(self, goal: Problem) -> list[Task]:
        """Return the tasks that a smaller problem leaves out."""
        return [task for task in self._problem.tasks if task.name not in goal.names]

    def _worth(self, plan: Plan, past: Past, system: TransitionSystem) -> Plan:
        """Return a plan with its worth for all tasks, those left out included."""
        return plan if self._goal is self._problem else valued(self._problem, past, plan, system)

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

    def _why_no_plan(self, surprise: str, error: NoPlanError) -> str:
        """Return why there is no plan any more for all tasks, in a sentence."""
        why, spared = [surprise], {task.name for task in self._left_out(self._goal)}
        if broken := violated(self._goal, self._labels):
            why.append(f"{' and '.join(broken)} {'is' if len(broken) == 1 else 'are'} violated beyond repair")
        elif error.reason.kind == "rule" and spared.issuperset(error.reason.tasks):
            why.append(f"what is left to do would make {' and '.join(error.reason.tasks)} impossible")
        elif self._failures.repeated:
            why.append(f"given up after {MAX_ATTEMPTS} attempts")
        elif self._failures:
            why.append("there is no way round it")
        else:
            why.append(str(error.reason))
        return "; ".join([*why, *(f"{obj} {reason}" for obj, reason in self.run.lost.items())])

    def _leave_tasks_out(self, why: str, past: Past, system: TransitionSystem) -> None:
        """Pursue those tasks alone that can still be done without making one of the others impossible for good.

        Raises:
            _GivenUp: there are none, or nothing is left to do for them.
        """
        goal = self._goal
        found = achievable(goal, past, system)
        if found is None:
            raise _GivenUp(why)
        possible, plan = found
        lost = spoiled(self._problem, past, plan, system)
        spoils = [task.name for task in self._left_out(possible) if task.name in lost]
        kept = achievable(goal, past, system, spared=self._left_out(goal)) if spoils else found
        if kept is None or len(kept[1].actions) <= len(past.actions):
            raise _GivenUp(f"{why}; {_what_could_be(possible, plan, spoils)}")
        self._goal, self._go_on = kept[0], continue_cheaply
        self.plan = self._worth(kept[1], past, system)
        left_out = [name for name in goal.names if name not in possible.names]
        words = [f"{' and '.join(left_out)} left out"] if left_out else []
        if harmful := [name for name in possible.names if name not in self._goal.names]:
            words.append(f"{' and '.join(harmful)} left out so that {' and '.join(spoils)} can still be satisfied")
        self._shortfalls.append("; ".join([why, *words]))


def _what_could_be(problem: Problem, plan: Plan, spoils: Sequence[str]) -> str:
    """Return in words what a plan would do for the tasks of a problem, and which others it would make impossible."""
    skipped = {bought.task for bought in plan.relaxations if bought.assume is None}
    ends = {"satisfied": set(problem.names) - skipped, "skipped": skipped}
    words = [
        f"{' and '.join(name for name in problem.names if name in names)} could still be {end}"
        for end, names in ends.items()
        if names
    ]
    but = f", but then {' and '.join(spoils)} never" if spoils else ""
    return f"{' and '.join(words)}, at a total cost of {plan.cost}{but}"
