"""Plans and Pareto fronts: what the search found, in the user's words and units."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field

from prefplan.errors import PrefplanError
from prefplan.quanta import Number


@dataclass(frozen=True)
class Plan:
    """One way to satisfy all tasks.

    Attributes:
        cost: total cost (equation 1).
        preference: mu (Definition 5).
        task_costs: c_i by task name (equation 2).
        actions: the plan.
        states: the trajectory, one state more than there are actions.
    """

    cost: Number
    preference: Number
    task_costs: dict[str, Number]
    actions: tuple[str, ...]
    states: tuple[Hashable, ...]


@dataclass(frozen=True)
class Reason:
    """Why there is no plan.

    Attributes:
        kind: `task` (it can never be satisfied), `conflict` (these cannot be satisfied together) or `bound`.
        tasks: the tasks to blame; empty for `bound`.
        smallest: for `bound`, the smallest mu (or, under a cost bound, the smallest cost) that is possible.
    """

    kind: str
    tasks: tuple[str, ...] = ()
    smallest: Number | None = None

    def __str__(self) -> str:
        """Return the reason as a sentence."""
        names = ", ".join(self.tasks)
        if self.kind == "task":
            return f"task {names} can never be satisfied"
        if self.kind == "conflict":
            return f"tasks {names} cannot be satisfied together, though any fewer of them can"
        return f"no plan lies within the bound; the smallest possible is {self.smallest}"


class NoPlanError(PrefplanError):
    """No plan satisfies all tasks within the bounds; `reason` says why."""

    def __init__(self, reason: Reason) -> None:
        """Keep the reason and make it the message."""
        super().__init__(str(reason))
        self.reason = reason


@dataclass(frozen=True)
class Stats:
    """Work and time of a search.

    Attributes:
        states: product states met.
        expanded: labels expanded.
        generated: labels made.
        build_seconds: automata and product tables.
        seconds: heuristic and search.
    """

    states: int = 0
    expanded: int = 0
    generated: int = 0
    build_seconds: float = 0.0
    seconds: float = 0.0


@dataclass(frozen=True)
class Front(Sequence[Plan]):
    """All non-dominated (cost, mu), one plan each, in order of rising cost and falling mu.

    Attributes:
        plans: the points.
        complete: whether the search ran to its end.
        reason: why there is no plan; None if there is one.
        stats: work and time.
    """

    plans: tuple[Plan, ...]
    complete: bool = True
    reason: Reason | None = None
    stats: Stats = field(default_factory=Stats)

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.plans)

    def __getitem__(self, index):  # type: ignore[no-untyped-def]
        """Return a point by its place."""
        return self.plans[index]
