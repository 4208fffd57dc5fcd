"""What an arm can do, as a planner asks for it: the protocol that a simulation implements, and what answers exclude.

The planner asks for nothing but what its plans need. A plan that needs what the arm cannot do is searched for again
without that; leaving actions out makes no plan cheaper, so plans that hold are the best that the arm can carry out.
(Lazy collision checking does the same on a roadmap: R. Bohlin and L. E. Kavraki, "Path planning using lazy PRM", ICRA
2000; for tasks and motions: C. R. Garrett et al., "PDDLStream", ICAPS 2020.)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, pairwise
from typing import TYPE_CHECKING, Protocol

from prefplan.exact_costs import Number
from prefplan.limits import check_limits
from prefplan.models.manipulation.symbolic import ManipulationState, at, never_directly
from prefplan.models.system import Barred
from prefplan.text.layout import number

if TYPE_CHECKING:
    from prefplan.plan import Plan

Move = tuple[str, str, str]
"""An object, and the locations from which and to which it is brought."""

MOST_NAMED = 3
"""Most exclusions, and most plans, that a sentence names."""


class Answer(Protocol):
    """What an arm can do with an object at a location."""

    @property
    def barred(self) -> Barred:
        """The actions that it cannot do there, each with the propositions under which it cannot: none for always."""

    @property
    def reason(self) -> str | None:
        """Why it cannot do them, for people."""


class Feasible(Protocol):
    """What an arm can do in a scene. The answers never change."""

    def check(self, obj: str, location: str) -> Answer:
        """Return what the arm can do with an object at a location: grasp it there, put it down there."""

    def brings(self, obj: str, source: str, location: str) -> bool:
        """Return whether the arm can bring an object from one location to another, both of which `check` allows.

        If not, no grasp suits both, and it may have to put the object down elsewhere on the way.
        """


class Geometry:
    """What is known of what an arm can do, as far as plans needed it, and what was left out of them for that.

    Attributes:
        left_out: by object and location, why the arm cannot do there what plans needed, in the order in which it was
            found; a conflict of several objects is told for one of them.
        abstract: values of the objectives of the plans that there would be if it could, in the order of the front;
            empty if nothing was left out.
        lost: those of them that no plan has now.
    """

    def __init__(self, feasible: Feasible, past: int = 0) -> None:
        """Take whom to ask, and the number of actions with which every plan begins, which are done already."""
        self.left_out: dict[tuple[str, str], str] = {}
        self.abstract: list[dict[str, Number]] = []
        self.lost: list[dict[str, Number]] = []
        self._feasible, self._past = feasible, past
        self._answers: dict[tuple[str, str], Answer] = {}
        self._conflicts = set[frozenset[str]]()
        self._direct: dict[Move, bool] = {}

    def excluded(self, plans: Sequence[Plan]) -> tuple[Barred, list[str]]:
        """Return what the arm cannot do of what some plans need; nothing if it can carry out all of them.

        These are actions, and formulas of rules: a location may be reached from elsewhere only.

        Raises:
            LimitError: a limit was reached before all answers were known.
        """
        found, formulas = dict[tuple[frozenset[str], str], None](), list[str]()
        try:
            for plan in plans:
                barred = [entry for pair in self._pairs(plan) for entry in self._barred(plan, pair)]
                found |= dict.fromkeys(barred)
                if not barred:  # else another plan takes its place
                    formulas += [self._never(move) for move in self._moves(plan) if self._is_impossible(move)]
        finally:
            if self.left_out and not self.abstract:
                self.abstract = [each.objectives for each in plans]
        return list(found), formulas

    def _barred(self, plan: Plan, pair: tuple[str, str]) -> Barred:
        """Return what excludes an action of a plan with an object at a location, and tell why."""
        if pair not in self._answers:
            check_limits()
            self._answers[pair] = self._feasible.check(*pair)
        answer = self._answers[pair]
        barred = self._violated(plan, answer)
        for conditions, _ in barred:
            conflict = conditions | {at(*pair)}
            if answer.reason or conflict not in self._conflicts:
                self.left_out.setdefault(pair, answer.reason or self._crowded(plan, pair, conditions))
                self._conflicts.add(conflict)
        return barred

    def _is_impossible(self, move: Move) -> bool:
        """Return whether the arm cannot bring an object from one location directly to another."""
        if move not in self._direct:
            check_limits()
            self._direct[move] = self._feasible.brings(*move)
        return not self._direct[move]

    def _never(self, move: Move) -> str:
        """Return the formula that excludes a move, and tell of it."""
        obj, source, location = move
        self.left_out.setdefault((obj, location), f"directly from {source}")
        return never_directly(obj, location, [source])

    def compare(self, plans: Sequence[Plan]) -> None:
        """Find what is lost, now that a search has ended with these plans."""
        found = [plan.objectives for plan in plans] if self.abstract else []
        self.lost = [values for values in self.abstract if values not in found]

    def _crowded(self, plan: Plan, pair: tuple[str, str], conditions: frozenset[str]) -> str:
        """Return beside which objects of a plan there is no room."""
        states = [state for state in plan.states if isinstance(state, ManipulationState)]
        words = {at(*other): "{} at {}".format(*other) for state in states for other in state.places}
        return f"no room beside {' and '.join(words.get(name, name) for name in sorted(conditions - {at(*pair)}))}"

    def holds(self, plan: Plan) -> bool:
        """Return whether it is known that the arm can do all that a plan needs."""
        pairs = self._pairs(plan)
        return all(map(self._direct.get, self._moves(plan))) and all(
            pair in self._answers and not self._violated(plan, self._answers[pair]) for pair in pairs
        )

    @property
    def note(self) -> str | None:
        """What was left out and its price, as one line; None if nothing was."""
        if not self.left_out:
            return None
        said = [f"{obj} at {location} ({reason})" for (obj, location), reason in self.left_out.items()]
        values = [", ".join(f"{name} {number(value)}" for name, value in each.items()) for each in self.lost]
        price = f"If it could: {_first(values)}." if values else "Other plans are as good."
        return f"The arm cannot do {_first(said)}. {price}"

    def _pairs(self, plan: Plan) -> Iterator[tuple[str, str]]:
        """Yield each object and location where a plan grasps it or puts it down."""
        states = [state for state in plan.states[self._past :] if isinstance(state, ManipulationState)]
        for before, after in pairwise(states):
            yield from sorted(set(before.places) ^ set(after.places))

    def _violated(self, plan: Plan, answer: Answer) -> Barred:
        """Return what of an answer excludes an action of a plan in the state in which it has it."""
        steps = list(zip(plan.states[self._past :], plan.actions[self._past :], strict=False))
        return [
            (conditions, text)
            for conditions, text in answer.barred
            if any(
                action == text and isinstance(state, ManipulationState) and conditions <= state.label
                for state, action in steps
            )
        ]

    def _moves(self, plan: Plan) -> Iterator[Move]:
        """Yield each object that a plan puts down, with the location where it was before, and the new one."""
        places = [state.place for state in plan.states if isinstance(state, ManipulationState)]
        for obj in dict.fromkeys(chain.from_iterable(places)):
            rests = [(k, place[obj]) for k, place in enumerate(places) if obj in place]
            for (_, source), (k, location) in pairwise(rests):
                if k > self._past and source != location:
                    yield obj, source, location


def _first(parts: Sequence[str]) -> str:
    """Return the first parts of an enumeration, and the number of the others."""
    return "; ".join([*parts[:MOST_NAMED], *[f"{len(parts) - MOST_NAMED} more"] * (len(parts) > MOST_NAMED)])
