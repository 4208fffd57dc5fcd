"""Failed actions, and what plans made after them leave out or bring first."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Sequence

from prefplan.models.manipulation.action import at, holding
from prefplan.models.manipulation.model import ManipulationState
from prefplan.problem import Problem, Rule
from prefplan.replanning import with_rules
from sim.execution.executor import Execution

MAX_ATTEMPTS = 3
"""Number of times an action may lead to the same unexpected state before it is given up; and of failed ways to put an
object down at a location."""


class Failures:
    """The failed actions of an execution.

    Attributes:
        barred: actions that plans must not contain where some propositions hold.
        repeated: whether an action failed so often that it was given up.
    """

    def __init__(self) -> None:
        """Nothing has failed yet."""
        self.barred: set[tuple[frozenset[str], str]] = set()
        self.repeated = False
        self._attempts: Counter[tuple[str, ManipulationState]] = Counter()
        # Rules, by the object, where it was taken, and where it is not to be put before it was elsewhere.
        self._detours: dict[tuple[str, str, str], str] = {}
        # What is barred instead where no plan has these detours; they are not tried any more then.
        self._instead: set[tuple[frozenset[str], str]] = set()
        self._detours_barred = False

    def __bool__(self) -> bool:
        """Whether plans leave anything out."""
        return bool(self.barred or self._detours)

    def record(self, run: Execution, problem: Problem, before: Sequence[ManipulationState]) -> None:
        """Record the last action of an execution as failed; it counts if it was blocked, or failed repeatedly.

        Args:
            run: the execution.
            problem: what is pursued.
            before: the observed states up to that action.
        """
        action, state = run.steps[-1].action, run.steps[-1].observed
        self._attempts[action, state] += 1
        repeated = self._attempts[action, state] >= MAX_ATTEMPTS
        self.repeated |= repeated
        if repeated or run.blocked is not None:
            bars = self._instead if self._adds_detour(run, problem, before) else self.barred
            bars |= {(_conditions(run, s), action) for s in (before[-1], state)}

    def with_detours(self, problem: Problem, labels: Sequence[frozenset[str]]) -> Problem:
        """Return a problem with the rules of detours, but those that are broken by the last label."""
        if not self._detours:
            return problem
        taken = {*problem.names, *(rule.name for rule in problem.rules)}
        names = (name for k in itertools.count() if (name := f"detour_{k}") not in taken)
        rules = [Rule(name, formula) for name, formula in zip(names, self._detours.values(), strict=False)]
        # An object may have been taken from a temporary location, which the problem does not know.
        sources = {at(obj, source) for obj, source, _ in self._detours}
        system = problem.system.knowing(problem.system.propositions | sources)
        knowing = Problem(system, problem.tasks, problem.preference, rules=problem.rules)
        return with_rules(knowing, rules, labels)

    def bar_detours(self) -> bool:
        """Bar what detours were to replace, from now on; return whether there were any."""
        found = bool(self._detours)
        self.barred |= self._instead
        self._detours.clear()
        self._detours_barred = True
        return found

    def _adds_detour(self, run: Execution, problem: Problem, before: Sequence[ManipulationState]) -> bool:
        """Let plans bring a held object that a fixture keeps from a location elsewhere first; return whether they may.

        The hand may not come there as it took the object where that was; from elsewhere it takes it in another way.
        Then no plan brings it from the one place straight to the other any more.
        """
        symbolic = run.scene.model.action(run.steps[-1].action)
        obj, target = symbolic.obj, symbolic.location
        if run.steps[-1].observed.held != obj or not _is_blocked_by_fixtures(run):
            return False
        source = next((state.place[obj] for state in reversed(before) if obj in state.place), "")
        known = source and at(obj, target) in problem.system.propositions
        tried = [start for other, start, end in self._detours if (other, end) == (obj, target)]
        if not known or source == target or source in tried or len(tried) >= MAX_ATTEMPTS or self._detours_barred:
            return False
        held = holding(obj)
        self._detours[obj, source, target] = f"G !({at(obj, source)} & X ({held} & ({held} U {at(obj, target)})))"
        return True


def _is_blocked_by_fixtures(run: Execution) -> bool:
    """Return whether the last action was blocked, or its goal out of reach, and no object is in the way."""
    return run.blocked is not None and not any(name in run.scene.shapes for name in run.blocked)


def _conditions(run: Execution, state: ManipulationState) -> frozenset[str]:
    """Return the propositions of a state under which the last action would fail again.

    An action that another object blocks is barred until an object moves. One that a fixture blocks, or whose goal
    is out of reach, is barred until its own object moves. A transit has no object, and its path depends on how
    high the objects are piled up: it is barred until any object moves, or if a fixture keeps the hand from where
    an object lies off every location, until that one does.
    """
    symbolic = run.scene.model.action(run.steps[-1].action)
    obj = symbolic.obj
    if not obj and symbolic.location in run.scene.temporary:
        obj = next((name for name, place in state.place.items() if place == symbolic.location), "")
    if not obj or not _is_blocked_by_fixtures(run):
        return state.label
    return state.label & {holding(obj), at(obj, state.place.get(obj, ""))} or state.label
