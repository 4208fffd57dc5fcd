"""Closed loop: executes a plan, and plans again when an observation affects the rest of the plan."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import cast

from prefplan import replanning
from prefplan.errors import ModelError, PrefplanError
from prefplan.front import NoPlanError
from prefplan.models.manipulation.model import ManipulationState
from prefplan.models.system import System
from prefplan.plan import Plan
from prefplan.problem import Problem, Task
from sim.execution.executor import Execution
from sim.execution.failures import MAX_ATTEMPTS, Failures
from sim.perception.sensors import ObservationTimeoutError
from sim.perception.world_model import spots_in
from sim.simulation.run import Run, ledger_of

MAX_REPLANS = 10
"""Greatest number of new plans in one execution."""

GoOn = Callable[[Problem, replanning.Past, System], Plan]
"""Returns a new plan, which begins with the past; raises NoPlanError if there is none."""


class _GivenUp(Exception):
    """The execution is given up; the message says why."""


class ClosedLoop:
    """The `execution` of a `plan`, with new plans after mismatches.

    After a completed run, the actions of `plan` are those that were carried out.
    """

    def __init__(
        self,
        execution: Execution,
        problem: Problem,
        plan: Plan,
        *,
        go_on: GoOn,
        on_progress: Callable[[int, int, str], None] = lambda done, total, action: None,
    ) -> None:
        """Prepare to carry out a problem's plan by `run`; the execution is at its start.

        `go_on` returns the plan to follow after a mismatch, e.g. `prefplan.replanning.continue_cheaply`; `on_progress`
        is called before each action with the number of actions done, the number of all actions, and the action's name.
        """
        self.execution, self.plan = execution, plan
        self._problem, self._go_on, self._on_progress = problem, go_on, on_progress
        # The problem without the tasks that were given up, and the reasons.
        self._goal = problem
        self._shortfalls: list[str] = []
        self._states: list[ManipulationState] = [cast(ManipulationState, problem.system.decode(problem.system.start))]
        self._replans = self._retries = 0
        self._failures = Failures()

    @property
    def _labels(self) -> list[frozenset[str]]:
        return [state.label for state in self._states]

    def record(self) -> Run:
        """Return the run so far, after the arm has come to rest."""
        violated = replanning.violated(self._problem, self._labels)
        return replace(self.execution.record(), replans=self._replans, retries=self._retries, violated=violated)

    def run(self) -> None:
        """Carry the plan out until it is completed or given up; if it is given up, `execution.reason` says why.

        If some tasks can no longer be satisfied, the others still are, except those that would make one of the former
        impossible for good.
        """
        try:
            if not self.execution.check_state():
                self._replan()
            while not self._is_completed():
                done = len(self.execution.steps)
                action = self.plan.actions[done]
                self._on_progress(done, len(self.plan.actions), action)
                if self.execution.step(action, ahead=self.plan.actions[done + 1 :]):
                    self._states.append(self.execution.steps[-1].observed)
                else:
                    self._replan()
            self._on_progress(len(self.plan.actions), len(self.plan.actions), "")
        except _GivenUp as end:
            self._shortfalls.append(str(end))
        finally:
            self.execution.injector.end()
        if self._shortfalls:
            self.execution.reason = "; ".join(self._shortfalls)
            self.execution.cell.log_event("ended", reason=self.execution.reason)

    def _is_completed(self) -> bool:
        """Return whether all actions are done and an observation of objects at rest confirms the final state."""
        for _ in range(MAX_REPLANS):
            if len(self.execution.steps) < len(self.plan.actions):
                return False
            if self.execution.check_state(at_rest=True):
                return True
            surprise = self.execution.reason
            self._replan()
        raise _GivenUp(surprise)

    def _replan(self) -> None:
        """Ground the current state in an observation, and follow the best plan from there, or the old one."""
        run, surprise = self.execution, self.execution.reason or ""
        if run.lost_sensor:
            raise _GivenUp(surprise)
        lost = run.lost.keys()
        try:
            state = run.reground()
            if run.steps:
                self._failures.record(run, self._states)
        except ObservationTimeoutError as error:
            raise _GivenUp(f"{surprise}; {error}") from None
        self._states[len(run.steps) :] = [state]
        ahead = self.plan.actions[max(len(run.steps) - 1, 0) :]
        # Tasks that were left out are taken up again if an object can be grasped again.
        resumed = self._goal is not self._problem and not lost <= run.lost.keys()
        if resumed:
            self._goal, self._shortfalls = self._problem, []
        try:
            system = self._system()
            if not resumed and self._is_unaffected(system):
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
        self._log_replan(surprise, actions)

    def _log_replan(self, surprise: str, actions: Sequence[str]) -> None:
        """Log a new plan, of which these actions are left."""
        detail: dict[str, object] = {"reason": surprise, "plan": list(actions)}
        detail |= {"cost": self.plan.cost, "preference": self.plan.preference}
        if broken := replanning.damaged(self._problem, self._labels):
            detail["violated"] = list(broken)
        if spots := spots_in(actions, self.execution.scene, self._states[-1]):
            detail["spots"] = spots
        self.execution.cell.log_event("replan", **detail)

    def _system(self) -> System:
        """Return the model from the current state on, without the actions barred after failures."""
        system = self.execution.scene.model.transition_system().without(self._failures.excluded)
        return system.after(self._states)

    def _plan_on(self, surprise: str, system: System) -> tuple[str, System]:
        """Plan from the current state in a model; return the reason for the new plan, and the model that it uses."""
        past, labels = self._past(), self._labels
        problem = replanning.keeping_satisfiable(self._goal, self._left_out(self._goal), labels)
        go_on = self._go_on if self._goal is self._problem else replanning.continue_cheaply
        try:
            plan = go_on(problem, past, system)
            if self._failures.rehearse(self.execution, self._states[-1], plan.actions[len(past.actions) :]):
                return self._plan_on(surprise, self._system())
        except NoPlanError as error:
            if self._failures.bar_detours():
                return self._plan_on(surprise, self._system())
            surprise = self._why_no_plan(surprise, error)
            self._leave_tasks_out(surprise, past, system)
            return surprise, system
        self.plan = self._valued(plan, past, system)
        return surprise, system

    def _left_out(self, goal: Problem) -> list[Task]:
        """Return the tasks that a smaller problem leaves out."""
        return [task for task in self._problem.tasks if task.name not in goal.names]

    def _valued(self, plan: Plan, past: replanning.Past, system: System) -> Plan:
        """Return a plan with its costs and penalty for all tasks, including those left out."""
        return plan if self._goal is self._problem else replanning.valued(self._problem, past, plan, system)

    def _is_unaffected(self, system: System) -> bool:
        """Return whether the rest of the plan has the predicted labels and costs in a new model, too."""
        run = self.execution
        rest = self.plan.actions[len(run.steps) :]
        try:
            _, _, labels, costs = system.trajectory(rest)
            _, _, predicted, planned = replace(run.system, start=run.predicted).trajectory(rest)
        except ModelError:
            return False
        told = self._problem.task_propositions
        return costs == planned and [label & told for label in labels] == [label & told for label in predicted]

    def _past(self) -> replanning.Past:
        """Return the executed actions, and the observed state before each of them."""
        steps = self.execution.steps
        before = self._states[: len(steps)]
        return replanning.Past(
            tuple(step.action for step in steps),
            tuple(step.cost for step in steps),
            tuple(before),
            tuple(state.label for state in before),
        )

    def _why_no_plan(self, surprise: str, error: NoPlanError) -> str:
        """Return in words why there is no longer a plan for all tasks."""
        why, spared = [surprise], {task.name for task in self._left_out(self._goal)}
        if broken := replanning.violated(self._goal, self._labels):
            why.append(f"{' and '.join(broken)} {'is' if len(broken) == 1 else 'are'} violated beyond repair")
        elif error.reason.kind == "rule" and spared.issuperset(error.reason.tasks):
            why.append(f"what is left to do would make {' and '.join(error.reason.tasks)} impossible")
        elif self._failures.repeated:
            why.append(f"given up after {MAX_ATTEMPTS} attempts")
        elif self._failures:
            why.append("no other plan avoids it")
        else:
            why.append(str(error.reason))
        return "; ".join([*why, *(f"{obj} {reason}" for obj, reason in self.execution.lost.items())])

    def _leave_tasks_out(self, why: str, past: replanning.Past, system: System) -> None:
        """Continue with only those tasks that can be satisfied without making another one impossible for good."""
        goal = self._goal
        found = replanning.achievable(goal, past, system)
        if found is None:
            raise _GivenUp(why)
        possible, plan = found
        lost = replanning.tasks_lost_by(self._problem, past, plan, system)
        spoils = [task.name for task in self._left_out(possible) if task.name in lost]
        kept = replanning.achievable(goal, past, system, others=self._left_out(goal)) if spoils else found
        if kept is None or len(kept[1].actions) <= len(past.actions):
            raise _GivenUp("; ".join([why, *self._what_could_be(possible, plan, spoils)]))
        self._goal = kept[0]
        self.plan = self._valued(kept[1], past, system)
        left_out = [name for name in goal.names if name not in possible.names]
        words = [f"{' and '.join(left_out)} left out"] if left_out else []
        if harmful := [name for name in possible.names if name not in self._goal.names]:
            words.append(f"{' and '.join(harmful)} left out so that {' and '.join(spoils)} can still be satisfied")
        self._shortfalls.append("; ".join([why, *words]))

    def _what_could_be(self, problem: Problem, plan: Plan, spoils: Sequence[str]) -> list[str]:
        """Return in words which further tasks a plan would satisfy or skip, and which it would make impossible."""
        done = ledger_of(self._problem, self.plan, self.execution.steps).satisfied
        skipped = {bought.task for bought in plan.relaxations if bought.assume is None}
        ahead = [name for name in problem.names if done[name] is None]
        ends = {
            "satisfied": [name for name in ahead if name not in skipped],
            "skipped": [name for name in ahead if name in skipped],
        }
        words = [f"{' and '.join(names)} could still be {end}" for end, names in ends.items() if names]
        if not words:
            return []
        but = f", but then {' and '.join(spoils)} never" if spoils else ""
        return [f"{' and '.join(words)}, at a total cost of {plan.cost}{but}"]
