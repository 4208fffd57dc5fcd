"""What an arm can do: the protocol by which a planner asks a simulation, and the actions that the answers exclude.

The transfers of a plan are rehearsed, each among the objects at rest at that time. If a transfer fails, the search is
repeated without the actions that make it fail. Leaving actions out makes no plan cheaper, so the first plans whose
transfers all succeed are the best that the arm can carry out.
(Lazy collision checking does the same on a roadmap: R. Bohlin and L. E. Kavraki, "Path planning using lazy PRM", ICRA
2000; for tasks and motions: C. R. Garrett et al., "PDDLStream", ICAPS 2020.)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple, Protocol

from prefplan.exact_costs import Number
from prefplan.limits import check_limits
from prefplan.models.manipulation.symbolic import Barred, ManipulationState, at
from prefplan.models.manipulation.system import ManipulationSystem
from prefplan.text.layout import number

if TYPE_CHECKING:
    from prefplan.plan import Plan
    from prefplan.problem import Problem

MOST_NAMED = 3
"""Most exclusions, and most plans, that a sentence names."""


class Transfer(NamedTuple):
    """The part of a plan from one state with an empty hand to the next one, or to the end of the plan.

    Attributes:
        obj: the object that is grasped.
        source: the location where it is grasped.
        target: the location where it is put down; empty if it stays in the hand.
        others: every other object that rests somewhere, with its location, in the model's order.
    """

    obj: str
    source: str
    target: str
    others: tuple[tuple[str, str], ...]


class Answer(Protocol):
    """What an arm cannot do with an object at a location."""

    @property
    def location(self) -> str:
        """The location."""

    @property
    def barred(self) -> Barred:
        """The actions that the arm cannot do there, each with its conditions; without conditions it never can."""

    @property
    def reason(self) -> str | None:
        """The reason, for people; None if objects there leave no room for each other."""


class Feasible(Protocol):
    """What an arm can do in a scene. The answers never change."""

    def rehearse(self, transfer: Transfer) -> Answer | None:
        """Return what the arm cannot do of a transfer, for all states where this is known; None if it can do all."""


class Geometry:
    """The transfers that an arm is known to be able or unable to do, and the actions that plans leave out for this.

    Attributes:
        left_out: by object and location, why the arm cannot do there what plans needed, in order of discovery; a
            conflict of several objects is listed for one of them.
        abstract: objective values of the plans that exist if nothing is left out, in the order of the front; empty if
            nothing was left out.
        lost: the entries of `abstract` that no plan of the last search has.
    """

    def __init__(self, feasible: Feasible, past: int = 0) -> None:
        """Take whom to ask, and the number of actions at the beginning of every plan that are already done."""
        self.left_out: dict[tuple[str, str], str] = {}
        self.abstract: list[dict[str, Number]] = []
        self.lost: list[dict[str, Number]] = []
        self._feasible, self._past = feasible, past
        self._rehearsed: dict[Transfer, Answer | None] = {}
        self._conflicts = set[frozenset[str]]()
        self._applied = 0  # number of exclusions that `without` has applied
        self._barred: dict[tuple[frozenset[str], str], None] = {}

    def exclude(self, plans: Sequence[Plan]) -> bool:
        """Exclude what plans need but the arm cannot do; return whether there are exclusions for `without` to apply.

        Raises:
            LimitError: a limit was reached before all answers were known.
        """
        try:
            for plan in plans:
                for transfer in self._transfers(plan):
                    if (refused := self._rehearse(transfer)) is not None:
                        self._refuse(transfer, refused)
        finally:
            if self.left_out and not self.abstract:
                self.abstract = [each.objectives for each in plans]
        return len(self._barred) > self._applied

    def without(self, problem: Problem) -> Problem:
        """Return a problem without what is excluded."""
        assert isinstance(problem.system, ManipulationSystem)
        self._applied = len(self._barred)
        return problem.over(problem.system.without(list(self._barred)))

    def _rehearse(self, transfer: Transfer) -> Answer | None:
        """Return what the arm cannot do of a transfer."""
        if transfer not in self._rehearsed:
            check_limits()
            self._rehearsed[transfer] = self._feasible.rehearse(transfer)
        return self._rehearsed[transfer]

    def _refuse(self, transfer: Transfer, refused: Answer) -> None:
        """Exclude what the arm cannot do of a transfer."""
        pair = transfer.obj, refused.location
        for conditions, action in refused.barred:
            conflict = conditions | {at(*pair)}
            self._barred[conditions, action] = None
            if refused.reason or conflict not in self._conflicts:
                self.left_out.setdefault(pair, refused.reason or _crowded(transfer, conditions))
                self._conflicts.add(conflict)

    def compare(self, plans: Sequence[Plan]) -> None:
        """Set `lost` after a search that ended with these plans."""
        found = [plan.objectives for plan in plans] if self.abstract else []
        self.lost = [values for values in self.abstract if values not in found]

    def holds(self, plan: Plan) -> bool:
        """Return whether it is known that the arm can do all that a plan needs."""
        return all(
            transfer in self._rehearsed and self._rehearsed[transfer] is None for transfer in self._transfers(plan)
        )

    @property
    def note(self) -> str | None:
        """What was left out and its price, as one line; None if nothing was."""
        if not self.left_out:
            return None
        values = [", ".join(f"{name} {number(value)}" for name, value in each.items()) for each in self.lost]
        price = f"If it could: {_first(values)}." if values else "Other plans are as good."
        return f"The arm cannot do {self.words}. {price}"

    @property
    def words(self) -> str:
        """What was left out, and why."""
        return _first([f"{obj} at {location} ({reason})" for (obj, location), reason in self.left_out.items()])

    def _transfers(self, plan: Plan) -> Iterator[Transfer]:
        """Yield the transfers of a plan that are not done yet; one under way begins where its object was grasped."""
        states = [state for state in plan.states if isinstance(state, ManipulationState)]
        obj, grasped, rest = "", 0, dict[str, str]()
        for k, (before, after) in enumerate(pairwise(states), start=1):
            if before.held == after.held:
                continue
            if obj in rest and k > self._past:
                yield _transfer(obj, rest, after.place[obj])
            obj, grasped, rest = after.held or "", k, before.place
        if obj in rest and grasped > self._past:
            yield _transfer(obj, rest, "")


def _transfer(obj: str, places: dict[str, str], target: str) -> Transfer:
    """Return the transfer of an object to a location, given the places of all objects when it is grasped."""
    return Transfer(obj, places[obj], target, tuple((other, place) for other, place in places.items() if other != obj))


def _crowded(transfer: Transfer, conditions: frozenset[str]) -> str:
    """Return, as text, beside which objects there is no room for a transfer that fails under some conditions."""
    return (
        f"no room beside {' and '.join('{} at {}'.format(*one) for one in transfer.others if at(*one) in conditions)}"
    )


def _first(parts: Sequence[str]) -> str:
    """Return the first parts of an enumeration, and the number of the others."""
    return "; ".join([*parts[:MOST_NAMED], *[f"{len(parts) - MOST_NAMED} more"] * (len(parts) > MOST_NAMED)])
