"""What a search returns: the goals that it found, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from prefplan.errors import LimitError
from prefplan.exact_costs import Number, to_number
from prefplan.front import Stats
from prefplan.plan import Plan
from prefplan.search.paths import Paths

OTHER_VALUES = "a plan has other values in the model"


@dataclass(frozen=True)
class Goal:
    """A goal that a search found.

    Attributes:
        objectives: exact values of all costs and preferences, in the user's units.
        paths: the paths to all goals of the search.
        number: which of them leads to this one.
    """

    objectives: tuple[Any, ...]
    paths: Paths = field(repr=False)
    number: int

    @cached_property
    def point(self) -> tuple[Number, ...]:
        """The values of all costs and preferences as they are printed."""
        return tuple(map(to_number, self.objectives))

    @cached_property
    def plan(self) -> Plan:
        """The plan that leads to the goal; it is asserted that its values in the model are those of the search."""
        plan = self.paths.plan(self.number)
        assert tuple(plan.objectives.values()) == self.point, OTHER_VALUES
        return plan


@dataclass(frozen=True)
class Result:
    """What a search has found so far.

    Attributes:
        goals: points of the front, in order of the objectives.
        ended: what stopped it: `time`, `memory` or `interrupt`; None if nothing did.
        complete_below: all points of lower cost, units, are among the goals; infinite once the search ran to its end.
        work: of the search.
        incumbents: where there is no goal, the goal of a plan that need not be a point of the front, if one is known.
    """

    goals: tuple[Goal, ...] = ()
    ended: str | None = None
    complete_below: float = 0
    work: Stats = Stats()
    incumbents: tuple[Goal, ...] = ()

    def check(self) -> None:
        """Assert that the values of all goals are those that their paths have in the model."""
        if self.goals:
            derived = self.goals[0].paths.objectives()
            for goal in self.goals:
                values = derived[goal.number]
                assert values == goal.objectives or tuple(map(to_number, values)) == goal.point, OTHER_VALUES


def ended_by(error: LimitError | KeyboardInterrupt) -> str:
    """Return what stopped a search that an error ended; see `Result.ended`."""
    return error.ended if isinstance(error, LimitError) else "interrupt"
