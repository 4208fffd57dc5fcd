"""Plans and Pareto fronts: what the search found, in the user's words and units."""

from __future__ import annotations

import operator
from collections.abc import Collection, Hashable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from html import escape
from typing import TYPE_CHECKING, overload

from prefplan.errors import PrefplanError
from prefplan.exact_costs import Number

if TYPE_CHECKING:
    # Neither is loaded before a front is drawn or made a table.
    from matplotlib.axes import Axes
    from pandas import DataFrame


PAIR = ("cost", "preference")
"""The names of one cost and one preference that have no others."""


@dataclass(frozen=True)
class Purchase:
    """A relaxation that a plan uses.

    Attributes:
        task: name of the task that is relaxed, or of the rule that is broken.
        step: actions taken before the reading.
        assume: proposition that was taken to hold; None if the task was dropped or the rule broken.
        cost: price.
        rule: whether it is a rule that is broken.
    """

    task: str
    step: int
    assume: str | None
    cost: Number
    rule: bool = field(default=False, repr=False)


@dataclass(frozen=True)
class Plan:
    """One way to satisfy all tasks, or as much of them as relaxations leave.

    Attributes:
        cost: total cost (equation 1).
        preference: mu (Definition 5).
        task_costs: c_i by task name (equation 2); the whole plan's cost for a task that is never satisfied.
        violation_costs: v_i by task name: what was paid to relax it; also by name of each rule that may be broken.
        actions: the plan.
        states: the trajectory, one state more than there are actions.
        relaxations: what was relaxed where, in order of steps.
        costs: every total cost by name, `cost` the first.
        preferences: every mu by name, `preference` the first.
    """

    cost: Number
    preference: Number
    task_costs: dict[str, Number]
    violation_costs: dict[str, Number]
    actions: tuple[str, ...]
    states: tuple[Hashable, ...]
    relaxations: tuple[Purchase, ...] = ()
    costs: dict[str, Number] = field(default_factory=dict)
    preferences: dict[str, Number] = field(default_factory=dict)

    @property
    def objectives(self) -> dict[str, Number]:
        """What the plan is worth, by the names of costs and preferences; they are distinct."""
        return self.costs | self.preferences


@dataclass(frozen=True)
class Reason:
    """Why there is no plan.

    Attributes:
        kind: `task` (it can never be satisfied), `conflict` (these cannot be satisfied together), `rule` (no plan keeps
            these) or `bound`.
        tasks: the tasks or rules to blame; empty for `bound`.
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
        if self.kind == "rule":
            return f"every plan breaks {'the rule' if len(self.tasks) == 1 else 'one of the rules'} {names}"
        known = "" if self.smallest is None else f"; the smallest possible is {self.smallest}"
        return f"no plan lies within the bound{known}"


class NoPlanError(PrefplanError):
    """No plan satisfies all tasks within the bounds; `reason` says why."""

    def __init__(self, reason: Reason) -> None:
        """Keep the reason and make it the message."""
        super().__init__(str(reason))
        self.reason = reason


def stopped_by(ended: str) -> str:
    """Return in words what ended a search."""
    return "interrupted" if ended == "interrupt" else f"stopped by the {ended} limit"


class UnfinishedError(PrefplanError):
    """A limit ended the search for one plan before that plan was known; there may well be one.

    Attributes:
        ended: what ended it: `time`, `memory` or `interrupt`.
        complete_below: no plan that keeps the bounds and is cheaper than this is missing; None if that is not known.
        best: the best plan known by then, or None.
        within: percentage by which the best plan may exceed the least value of what is minimised; None if unknown.
    """

    def __init__(
        self, ended: str, *, complete_below: Number | None = None, best: Plan | None = None, within: float | None = None
    ) -> None:
        """Keep how far the search got, and say it."""
        what = "no plan is known yet" if best is None else "a better plan may exist"
        what += f"; this one costs at most {within} % more than any" if within is not None else ""
        below = "" if not complete_below or best else f"; any costs at least {complete_below}"
        super().__init__(f"{stopped_by(ended)}: {what}{below}")
        self.ended, self.complete_below, self.best, self.within = ended, complete_below, best, within


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

    With several costs or preferences the points are not dominated in all of them, in order of the first cost.

    Attributes:
        plans: the points.
        reason: why there is no plan; None if there is one, or if that is not known.
        ended: None if the search ran to its end, else what stopped it: `time`, `memory` or `interrupt`.
        complete_below: every point of lower cost has been found, and what is dearer is a plan that may be none of the
            front; None if the front is complete, or within some percent.
        within: every point of the exact front has one here that exceeds it by at most this percentage in cost and in
            mu; 0 for a complete front, None where the search was stopped before it could prove any.
        resolution: of what the model's costs were rounded to a multiple; None if they are as they were given.
        claimed: whether the preference's contract is the user's claim: tried on random costs, but not shown.
        stats: work and time.
    """

    plans: tuple[Plan, ...]
    reason: Reason | None = None
    ended: str | None = None
    complete_below: Number | None = None
    within: Number | None = None
    resolution: Number | None = None
    claimed: bool = False
    stats: Stats = field(default_factory=Stats)

    @property
    def objectives(self) -> tuple[str, ...]:
        """The names of the costs and the preferences; none if there is no plan."""
        return tuple(self.plans[0].objectives) if self.plans else ()

    @property
    def complete(self) -> bool:
        """Whether the search ran to its end."""
        return self.ended is None

    @property
    def ending(self) -> str | None:
        """What stopped the search and how far it got, as a sentence; None if it ran to its end."""
        if self.ended is None:
            return None
        below = "" if not self.complete_below else f"; the front is complete below cost {self.complete_below}"
        proven = "" if self.within is None else f"; every best trade-off is within {self.within} % of one of these"
        return f"{stopped_by(self.ended)}{below}{proven}"

    def over(self, objectives: Collection[str]) -> Front:
        """Return the points that no other dominates in some costs and preferences alone, given by name.

        If the front is complete, so is the result: of each of its points, some plan is on the whole front.
        """
        kept: dict[tuple[Number, ...], Plan] = {}
        for plan in self:
            kept.setdefault(tuple(plan.objectives[name] for name in objectives), plan)
        plans = [
            plan
            for worth, plan in kept.items()
            if not any(other != worth and all(map(operator.le, other, worth)) for other in kept)
        ]
        return replace(self, plans=tuple(plans))

    def to_pandas(self) -> DataFrame:
        """Return a table of one row a plan: `cost`, `preference`, `task_costs.NAME` for every task, and `actions`.

        With several costs or preferences there is a column for each, by its name.

        Raises:
            PrefplanError: pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise PrefplanError("a front is made a DataFrame by pandas: pip install pandas") from None
        rows = [[*point_of(plan), *plan.task_costs.values(), plan.actions] for plan in self]
        tasks = [f"task_costs.{name}" for name in self._tasks]
        return pandas.DataFrame(rows, columns=[*(self.objectives or PAIR), *tasks, "actions"])

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the points, cost against preference penalty, along the border of what they dominate; return the axes.

        With several costs or preferences, what is drawn is the front of the first two.

        Args:
            ax: where to draw; None for a new figure.
        """
        if ax is None:
            from matplotlib import pyplot

            _, ax = pyplot.subplots()
        names = self.objectives[:2] or PAIR
        shown = self.over(names) if len(self.objectives) > 2 else self
        points = sorted(tuple(map(float, point_of(plan)[:2])) for plan in shown)
        ax.step([x for x, _ in points], [y for _, y in points], "o-", where="post")
        if self.complete_below is not None:
            ax.axvline(float(self.complete_below), linestyle="--", color="gray", label="complete up to here")
            ax.legend()
        x, y = ("total cost", "preference penalty") if names == PAIR else names
        ax.set(xlabel=x, ylabel=f"{y} (lower is better)")
        return ax

    @property
    def _tasks(self) -> tuple[str, ...]:
        return tuple(self.plans[0].task_costs) if self.plans else ()

    def _repr_html_(self) -> str:
        """Return the front as notebooks show it: a row a plan, and what keeps it from being whole."""
        rows = [_row("td", [i, *point_of(p), *p.task_costs.values()]) for i, p in enumerate(self)]
        named = ("cost", "penalty") if self.objectives in ((), PAIR) else self.objectives
        head = _row("th", ["", *named, *self._tasks])
        table = f"<table><thead>{head}</thead><tbody>{''.join(rows)}</tbody></table>" if rows else ""
        note = "" if rows else "No plan."
        if self.reason is not None:
            note = f"No plan: {self.reason}."
        elif self.ended is not None:
            note = f"Incomplete: {self.ending}."
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


def point_of(plan: Plan) -> tuple[Number, ...]:
    """Return the values of a plan's objectives."""
    return tuple(plan.objectives.values()) or (plan.cost, plan.preference)


def _row(tag: str, cells: Iterable[object]) -> str:
    """Return a row of an HTML table."""
    return f"<tr>{''.join(f'<{tag}>{escape(str(cell))}</{tag}>' for cell in cells)}</tr>"
