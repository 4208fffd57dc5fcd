"""Plans and Pareto fronts: what the search found, in the user's words and units."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, overload

from prefplan.errors import PrefplanError
from prefplan.exact_costs import Number

if TYPE_CHECKING:
    # Neither is loaded before a front is drawn or made a table.
    from matplotlib.axes import Axes
    from pandas import DataFrame


@dataclass(frozen=True)
class Purchase:
    """A relaxation that a plan uses.

    Attributes:
        task: name of the task that is relaxed.
        step: actions taken before the reading.
        assume: proposition that was taken to hold; None if the task was dropped.
        cost: price.
    """

    task: str
    step: int
    assume: str | None
    cost: Number


@dataclass(frozen=True)
class Plan:
    """One way to satisfy all tasks, or as much of them as relaxations leave.

    Attributes:
        cost: total cost (equation 1).
        preference: mu (Definition 5).
        task_costs: c_i by task name (equation 2); the whole plan's cost for a task that is never satisfied.
        violation_costs: v_i by task name: what was paid to relax it.
        actions: the plan.
        states: the trajectory, one state more than there are actions.
        relaxations: what was relaxed where, in order of steps.
    """

    cost: Number
    preference: Number
    task_costs: dict[str, Number]
    violation_costs: dict[str, Number]
    actions: tuple[str, ...]
    states: tuple[Hashable, ...]
    relaxations: tuple[Purchase, ...] = ()


@dataclass(frozen=True)
class Reason:
    """Why there is no plan.

    Attributes:
        kind: `task` (it can never be satisfied), `conflict` (these cannot be satisfied together) or `bound`.
        tasks: the tasks to blame; empty for `bound`.
        smallest: for `bound`, the smallest mu (or, under a cost bound, the smallest cost) that is possible; None where
            a limit of the search left it unknown, or no plan keeps the bound on the cost.
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
        known = "" if self.smallest is None else f"; the smallest possible is {self.smallest}"
        return f"no plan lies within the bound{known}"


class NoPlanError(PrefplanError):
    """No plan satisfies all tasks within the bounds; `reason` says why."""

    def __init__(self, reason: Reason) -> None:
        """Keep the reason and make it the message."""
        super().__init__(str(reason))
        self.reason = reason


class UnfinishedError(PrefplanError):
    """A limit ended the search for one plan before that plan was known; there may well be one.

    Attributes:
        ended: what ended it: `time` or `memory`.
        complete_below: no plan that keeps the bounds and is cheaper than this is missing; None if that is not known.
        best: the best plan known by then, or None.
    """

    def __init__(self, ended: str, *, complete_below: Number | None = None, best: Plan | None = None) -> None:
        """Keep how far the search got, and say it."""
        what = "no plan is known yet" if best is None else "a better plan may exist"
        below = "" if complete_below is None or best else f"; any costs at least {complete_below}"
        super().__init__(f"stopped by the {ended} limit: {what}{below}")
        self.ended, self.complete_below, self.best = ended, complete_below, best


@dataclass(frozen=True)
class Stats:
    """Work and time of a search.

    Attributes:
        states: product states met.
        expanded: labels expanded.
        generated: labels made.
        bytes: memory of the search at its end.
        build_seconds: automata and product tables.
        seconds: heuristic and search.
    """

    states: int = 0
    expanded: int = 0
    generated: int = 0
    bytes: int = 0
    build_seconds: float = 0.0
    seconds: float = 0.0


@dataclass(frozen=True)
class Front(Sequence[Plan]):
    """All non-dominated (cost, mu), one plan each, in order of rising cost and falling mu.

    Attributes:
        plans: the points.
        reason: why there is no plan; None if there is one, or if that is not known.
        ended: None if the search ran to its end, else what stopped it: `time`, `memory` or `interrupt`.
        complete_below: every point of lower cost has been found; None if the front is complete.
        resolution: of what the model's costs were rounded to a multiple; None if they are as they were given.
        claimed: whether the preference's contract is the user's claim: tried on random costs, but not shown.
        stats: work and time.
    """

    plans: tuple[Plan, ...]
    reason: Reason | None = None
    ended: str | None = None
    complete_below: Number | None = None
    resolution: Number | None = None
    claimed: bool = False
    stats: Stats = field(default_factory=Stats)

    @property
    def complete(self) -> bool:
        """Whether the search ran to its end."""
        return self.ended is None

    @property
    def ending(self) -> str | None:
        """What stopped the search and how far it got, as a sentence; None if it ran to its end."""
        if self.ended is None:
            return None
        why = "interrupted" if self.ended == "interrupt" else f"stopped by the {self.ended} limit"
        below = "" if self.complete_below is None else f"; the front is complete below cost {self.complete_below}"
        return f"{why}{below}"

    def to_pandas(self) -> DataFrame:
        """Return a table of one row a plan: `cost`, `preference`, `task_costs.NAME` for every task, and `actions`.

        Raises:
            PrefplanError: pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise PrefplanError("a front is made a DataFrame by pandas: pip install pandas") from None
        rows = [[plan.cost, plan.preference, *plan.task_costs.values(), plan.actions] for plan in self]
        tasks = [f"task_costs.{name}" for name in self._tasks]
        return pandas.DataFrame(rows, columns=["cost", "preference", *tasks, "actions"])

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the points, cost against preference penalty, along the border of what they dominate.

        Args:
            ax: where to draw; None for a new figure.

        Returns:
            The axes.
        """
        if ax is None:
            from matplotlib import pyplot

            _, ax = pyplot.subplots()
        costs, preferences = [float(plan.cost) for plan in self], [float(plan.preference) for plan in self]
        ax.step(costs, preferences, "o-", where="post")
        if self.complete_below is not None:
            ax.axvline(float(self.complete_below), linestyle="--", color="gray", label="complete up to here")
            ax.legend()
        ax.set(xlabel="total cost", ylabel="preference penalty (lower is better)")
        return ax

    @property
    def _tasks(self) -> tuple[str, ...]:
        return tuple(self.plans[0].task_costs) if self.plans else ()

    def _repr_html_(self) -> str:
        """Return the front as notebooks show it: a row a plan, and what keeps it from being whole."""
        rows = [_row("td", [i, p.cost, p.preference, *p.task_costs.values()]) for i, p in enumerate(self)]
        head = _row("th", ["", "cost", "penalty", *self._tasks])
        table = f"<table><thead>{head}</thead><tbody>{''.join(rows)}</tbody></table>" if rows else ""
        if self.reason is not None:
            note = f"No plan: {self.reason}."
        elif self.ended is not None:
            note = f"Incomplete: {self.ending}."
        else:
            note = "" if rows else "No plan."
        return table + (f"<p>{escape(note)}</p>" if note else "")

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.plans)

    @overload
    def __getitem__(self, index: int) -> Plan: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Plan, ...]: ...

    def __getitem__(self, index: int | slice) -> Plan | tuple[Plan, ...]:
        """Return a point by its place, or several."""
        return self.plans[index]


def _row(tag: str, cells: Iterable[object]) -> str:
    """Return a row of an HTML table."""
    return f"<tr>{''.join(f'<{tag}>{escape(str(cell))}</{tag}>' for cell in cells)}</tr>"
