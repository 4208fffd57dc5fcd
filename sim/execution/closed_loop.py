"""Closed loop: a plan carried out, and planned anew from what is seen wherever something is not as predicted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

from prefplan.errors import PrefplanError
from prefplan.front import NoPlanError, Plan
from prefplan.models.manipulation.model import ManipulationState
from prefplan.models.transition_system import TransitionSystem
from prefplan.problem import Problem
from prefplan.replanning import Past, achievable, damaged, violated
from sim.execution.executor import Run
from sim.perception.sensors import SightError

ATTEMPTS = 3
"""An action that fails so often without changing anything is given up."""

REPLANS = 10
"""So many new plans are made at most."""

GoOn = Callable[[Problem, Past, TransitionSystem], Plan]
"""Returns the plan to follow, which begins with the past; raises NoPlanError if there is none."""


@dataclass(frozen=True)
class Pursuit:
    """How the pursuit of a plan ended.

    Attributes:
        plan: the one that was followed last; its actions are what was carried out if it was completed.
        replans: how many times another plan was made.
        retries: how many times an action was tried again as it was.
        violated: tasks that what happened has put beyond repair.
    """

    plan: Plan
    replans: int = 0
    retries: int = 0
    violated: tuple[str, ...] = ()


class _GivenUp(Exception):
    """There is no going on; the message says why."""


class ClosedLoop:
    """The pursuit of a plan.

    Attributes:
        run: the execution.
        plan: the one followed at present.
    """

    def __init__(
        self,
        run: Run,
        problem: Problem,
        plan: Plan,
        *,
        go_on: GoOn,
        tell: Callable[[int, int, str], None] = lambda done, total, action: None,
    ) -> None:
        """Pursue a plan.

        Args:
            run: an execution at its start.
            problem: what was planned.
            plan: one of its plans.
            go_on: which plan to follow after a surprise, e.g. `prefplan.replanning.continue_cheaply`.
            tell: told before each action how many are done, how many there are, and its name.
        """
        self.run, self.plan = run, plan
        self._problem, self._go_on, self._tell = problem, go_on, tell
        self._states: list[ManipulationState] = [cast(ManipulationState, problem.system.states[problem.system.start])]
        self._replans = self._retries = 0
        self._attempts: list[tuple[str, ManipulationState]] = []
        self._barred: set[tuple[frozenset[str], str]] = set()

    @property
    def pursuit(self) -> Pursuit:
        """What has come of it so far."""
        labels = [state.label for state in self._states]
        return Pursuit(self.plan, self._replans, self._retries, violated(self._problem, labels))

    def pursue(self) -> None:
        """Carry the plan out until it is completed or there is no going on; then `run.reason` says why."""
        try:
            if not self.run.look():
                self._replan()
            while len(self.run.steps) < len(self.plan.actions):
                done = len(self.run.steps)
                action = self.plan.actions[done]
                self._tell(done, len(self.plan.actions), action)
                if self.run.carry_out(action):
                    self._states.append(self.run.steps[-1].observed)
                    self._attempts.clear()
                else:
                    self._replan()
            self._tell(len(self.plan.actions), len(self.plan.actions), "")
        except _GivenUp as end:
            self.run.reason = str(end)
            self.run.cell.tell("ended", reason=str(end))

    def _replan(self) -> None:
        """Take what is seen for the present, and follow the best plan from there.

        Raises:
            _GivenUp: there is none, or things went wrong too often.
        """
        run, surprise = self.run, self.run.reason or ""
        if run.blind:
            raise _GivenUp(surprise)
        try:
            state = run.reground()
        except SightError as error:
            raise _GivenUp(f"{surprise}; {error}") from None
        self._take_note(state, surprise)
        ahead = self.plan.actions[max(len(run.steps) - 1, 0) :]
        if self._replans >= REPLANS:
            raise _GivenUp(f"given up after {REPLANS} new plans, {surprise}")
        past = self._past()
        try:
            system = run.scene.model.transition_system().without(self._barred)
            self.plan = self._go_on(self._problem, past, system)
        except NoPlanError as error:
            raise _GivenUp(self._no_way_on(surprise, past, system, error)) from None
        except PrefplanError as error:
            raise _GivenUp(f"{surprise}; no plan can be made: {error}") from None
        run.go_on(system)
        again = self.plan.actions[len(run.steps) :] == ahead
        if again:
            self._retries += 1
            run.cell.tell("retry", action=ahead[0], reason=surprise)
            return
        self._replans += 1
        run.cell.tell(
            "replan",
            reason=surprise,
            plan=list(self.plan.actions[len(run.steps) :]),
            cost=self.plan.cost,
            preference=self.plan.preference,
            **self._damage(),
        )

    def _take_note(self, state: ManipulationState, surprise: str) -> None:
        """Keep the present state, and an action that fails again and again without changing anything."""
        steps = self.run.steps
        if not steps:
            self._states = [state]
            return
        attempt = (steps[-1].action, state)
        self._attempts = [*self._attempts, attempt] if attempt in self._attempts else [attempt]
        if len(self._attempts) >= ATTEMPTS or self.run.blocked is not None:
            self._barred.add((self._where_hopeless(state, steps[-1].action), steps[-1].action))
        self._states.append(state)

    def _where_hopeless(self, state: ManipulationState, action: str) -> frozenset[str]:
        """Return the propositions under which an action that failed would fail again.

        What fails for other objects may work when they are elsewhere; what fails for anything else does not, as long
        as the object of the action is where it is.
        """
        if self.run.blocked is None or any(name in self.run.scene.shapes for name in self.run.blocked):
            return state.label
        _, thing, *_ = action.split()
        return frozenset(
            name for name in (f"holding_{thing}", f"{thing}_{state.place.get(thing)}") if name in state.label
        )

    def _past(self) -> Past:
        """Return what was done so far, and what was seen before each action."""
        steps = self.run.steps
        before = self._states[: len(steps)]
        return Past(
            tuple(step.action for step in steps),
            tuple(step.cost for step in steps),
            tuple(before),
            tuple(state.label for state in before),
        )

    def _damage(self) -> dict[str, list[str]]:
        """Return the tasks that, as they are written, what happened has violated, for an event."""
        broken = damaged(self._problem, [state.label for state in self._states])
        return {"violated": list(broken)} if broken else {}

    def _no_way_on(self, surprise: str, past: Past, system: TransitionSystem, error: NoPlanError) -> str:
        """Return why there is no plan any more, and what could still be achieved, in a sentence."""
        labels = [state.label for state in self._states]
        why = [surprise]
        if broken := violated(self._problem, labels):
            why.append(f"{_listed(broken)} {'is' if len(broken) == 1 else 'are'} violated beyond repair")
        elif len(self._attempts) >= ATTEMPTS:
            why.append(f"given up after {ATTEMPTS} attempts")
        elif self._barred:
            why.append("there is no way round it")
        else:
            why.append(str(error.reason))
        why += [f"{lost} is out of reach" for lost in self.run.lost]
        rest = achievable(self._problem, past, system)
        if rest is not None and rest.task_costs:
            names = _listed(tuple(rest.task_costs))
            why.append(f"{names} could still be satisfied, at a total cost of {rest.cost}")
        return "; ".join(why)


def _listed(names: tuple[str, ...]) -> str:
    return " and ".join(names)
