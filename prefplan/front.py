"""Pareto fronts, as results for the user: in the user's names and units."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from html import escape
from operator import ge
from typing import TYPE_CHECKING, overload

from prefplan.errors import PrefplanError, check_known
from prefplan.exact_costs import Number
from prefplan.plan import PAIR, OnDemand, Plan, objectives_text, point_of
from prefplan.text.layout import counted, in_columns, listed, number

if TYPE_CHECKING:
    # Loaded only when a front is drawn or converted to a table.
    from matplotlib.axes import Axes
    from pandas import DataFrame

MOST_ACTIONS = 30
"""Most entries of a plan in the text of a front; an entry is an action, or several equal actions in a row."""


@dataclass(frozen=True)
class Reason:
    """Why there is no plan.

    Attributes:
        kind: `task` (it can never be satisfied), `conflict` (these cannot be satisfied together), `rule` (no plan keeps
            these) or `bound`.
        tasks: the tasks or rules to blame, empty for `bound`. For `conflict` and `rule`: if any of them is left out,
            the others can be satisfied.
        smallest: for `bound`, the least possible value of the bounded objective; if both cost and mu are bounded, that
            of mu within the cost bound. None if it is not known, or if no plan keeps the cost bound.
    """

    kind: str
    tasks: tuple[str, ...] = ()
    smallest: Number | None = None

    def __str__(self) -> str:
        """Return the reason as a sentence."""
        names = ", ".join(self.tasks)
        if self.kind == "task":
            return f"{'task' if len(self.tasks) == 1 else 'tasks'} {listed(self.tasks)} can never be satisfied"
        if self.kind == "conflict":
            return f"tasks {names} cannot be satisfied together, though any fewer of them can"
        if self.kind == "rule":
            return f"every plan breaks {'the rule' if len(self.tasks) == 1 else 'one of the rules'} {names}"
        least = "" if self.smallest is None else f"; the smallest possible is {self.smallest}"
        return f"no plan lies within the bound{least}"


class NoPlanError(PrefplanError):
    """No plan satisfies all tasks within the bounds; `reason` says why."""

    def __init__(self, reason: Reason) -> None:
        """Keep the reason and make it the message."""
        super().__init__(str(reason))
        self.reason = reason


def stopped_by(ended: str) -> str:
    """Return what ended a search, in words."""
    return "interrupted" if ended == "interrupt" else f"stopped by the {ended} limit"


class UnfinishedError(PrefplanError):
    """A limit ended the search before the wanted plan was found; the plan may exist.

    Attributes:
        ended: what ended the search: `time`, `memory` or `interrupt`.
        complete_below: all plans within the bounds that cost less were considered; None if not known.
        best: the best plan known by then, or None.
        within: percentage by which the best plan's cost may exceed the least cost; None if not known.
    """

    def __init__(
        self, ended: str, *, complete_below: Number | None = None, best: Plan | None = None, within: float | None = None
    ) -> None:
        """Keep how far the search got, and make it the message."""
        what = "no plan is known yet" if best is None else "a better plan may exist"
        what += f"; this one costs at most {within} % more than the cheapest" if within is not None else ""
        below = "" if not complete_below or best else f"; every plan costs at least {complete_below}"
        super().__init__(f"{stopped_by(ended)}: {what}{below}")
        self.ended, self.complete_below, self.best, self.within = ended, complete_below, best, within


@dataclass(frozen=True)
class Stats:
    """Work and time of a search.

    Attributes:
        states: number of product states met.
        expanded: number of labels expanded.
        generated: number of labels generated.
        bytes: memory of the search at its end.
        build_seconds: time to build automata and product, s.
        seconds: time of heuristics and search, s.
    """

    states: int = 0
    expanded: int = 0
    generated: int = 0
    bytes: int = 0
    build_seconds: float = 0.0
    seconds: float = 0.0

    def __add__(self, later: Stats) -> Stats:
        """Return the work of two searches, one after the other; memory and states are those of the larger one."""
        return Stats(
            max(self.states, later.states),
            self.expanded + later.expanded,
            self.generated + later.generated,
            max(self.bytes, later.bytes),
            self.build_seconds + later.build_seconds,
            self.seconds + later.seconds,
        )


@dataclass(frozen=True)
class Front(Sequence[Plan]):
    """All non-dominated (cost, mu), one plan each, in order of rising cost and falling mu.

    With several costs or preferences: all points that no other dominates, in order of the first cost.

    Attributes:
        plans: the points.
        reason: why there is no plan; None if there is one, or if the reason is not known.
        ended: None if the search ran to its end, else what stopped it: `time`, `memory` or `interrupt`.
        complete_below: every point of lower cost was found, while plans of higher cost may be dominated; None if the
            search ran to its end, or if no such cost is known.
        assumptions: sentences on the assumptions under which the front is exact, e.g. if costs were rounded.
        stats: work and time of the search.
        known_points: the `points`, if plans are made only when they are read; else None.
    """

    plans: Sequence[Plan]
    reason: Reason | None = None
    ended: str | None = None
    complete_below: Number | None = None
    assumptions: tuple[str, ...] = ()
    stats: Stats = field(default_factory=Stats, compare=False)
    known_points: Sequence[tuple[Number, ...]] | None = field(default=None, repr=False, compare=False)

    @property
    def objectives(self) -> tuple[str, ...]:
        """The names of the costs and the preferences; none if there is no plan."""
        return tuple(self.plans[0].objectives) if self.plans else ()

    @property
    def points(self) -> Sequence[tuple[Number, ...]]:
        """The values of the objectives of each plan."""
        return [*map(point_of, self.plans)] if self.known_points is None else self.known_points

    @property
    def complete(self) -> bool:
        """Whether the search ran to its end."""
        return self.ended is None

    @property
    def ending(self) -> str | None:
        """What stopped the search and how far it got, in words; None if it ran to its end."""
        below = f"; the front is complete below cost {self.complete_below}" if self.complete_below else ""
        return None if self.ended is None else f"{stopped_by(self.ended)}{below}"

    def over(self, objectives: Collection[str]) -> Front:
        """Return the front over some of the objectives, given by name; of plans with equal values, it has the first.

        It is complete if this front is, since this front has a plan for each of its points.

        Raises:
            PrefplanError: a name is not that of an objective.
        """
        for name in objectives if self.plans else ():
            check_known("over", "objective", name, self.objectives, PrefplanError)
        columns = [self.objectives.index(name) for name in objectives] if self.plans else []
        first: dict[tuple[Number, ...], int] = {}
        for k, point in enumerate(points := self.points):
            first.setdefault(tuple(point[column] for column in columns), k)
        kept = [k for one, k in first.items() if not any(other != one and all(map(ge, one, other)) for other in first)]
        plans = OnDemand(len(kept), lambda k: self.plans[kept[k]])
        return replace(self, plans=plans, known_points=[points[k] for k in kept])

    def to_pandas(self) -> DataFrame:
        """Return a table with a row for each plan: `cost`, `preference`, `task_costs.NAME` for each task, `actions`.

        With several costs or preferences there is a column for each, under its name.

        Raises:
            PrefplanError: pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise PrefplanError("a DataFrame needs pandas: pip install pandas") from None
        rows = [[*point_of(plan), *plan.task_costs.values(), plan.actions] for plan in self]
        tasks = [f"task_costs.{name}" for plan in self.plans[:1] for name in plan.task_costs]
        return pandas.DataFrame(rows, columns=[*(self.objectives or PAIR), *tasks, "actions"])

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the points, penalty over cost, as steps around the dominated region, on axes or a new figure.

        With several costs or preferences, the front of the first two is drawn.
        """
        if ax is None:
            from matplotlib import pyplot

            _, ax = pyplot.subplots()
        names = self.objectives[:2] or PAIR
        shown = self.over(names) if len(self.objectives) > 2 else self
        points = sorted(tuple(map(float, point[:2])) for point in shown.points)
        ax.step([x for x, _ in points], [y for _, y in points], "o-", where="post")
        if self.complete_below is not None:
            ax.axvline(float(self.complete_below), linestyle="--", color="gray", label="complete up to here")
            ax.legend()
        x, y = ("total cost", "penalty") if names == PAIR else names
        ax.set(xlabel=x, ylabel=f"{y} (lower is better)")
        return ax

    @property
    def title(self) -> str:
        """What the front is of."""
        return f"Pareto front of {listed(self._heads)}"

    @property
    def _heads(self) -> list[str]:
        return ["penalty" if name == PAIR[1] else name for name in self.objectives or PAIR]

    @property
    def table(self) -> list[list[str]]:
        """The heads of a table with a row for each plan, and then its rows."""
        rows = [[str(i), *map(number, (*point_of(p), *p.task_costs.values()))] for i, p in enumerate(self)]
        return [
            ["#", *self._heads, *(plan.display.task(name) for plan in self.plans[:1] for name in plan.task_costs)],
            *rows,
        ]

    @property
    def notes(self) -> list[str]:
        """Sentences below the table: what its columns are, the work of the search, and what the front assumes."""
        return [
            f"A task's column is its cost: the total {(self.objectives or PAIR)[0]} until it was satisfied. "
            f"{self.stats.seconds:.2f} s, {self.stats.expanded} labels expanded.",
            *self.assumptions,
        ]

    def listing(self, whole: Callable[[int], str]) -> list[str]:
        """Return each plan's heading and first actions; `whole` says how to see all, given the number of a plan."""
        return [
            f"Plan {i} ({counted(len(plan.actions), 'action')})\n{plan.listing(most=MOST_ACTIONS, whole=whole(i))}"
            for i, plan in enumerate(self)
        ]

    @property
    def missing(self) -> str | None:
        """Why the front is empty or incomplete, as a sentence; None if it is neither."""
        if self.reason is not None:
            return f"No plan: {self.reason}."
        if self.ended is not None:
            return f"Incomplete: {self.ending}."
        return None if self.plans else "No plan."

    def __repr__(self) -> str:
        """Return the number of plans, the first and the last point, and what is missing, in one line."""
        ends = " to ".join(dict.fromkeys(objectives_text(plan) for plan in (*self.plans[:1], *self.plans[-1:])))
        return f"<Front of {counted(len(self), 'plan')}: {'; '.join(filter(None, (ends, self.missing)))}>"

    def __str__(self) -> str:
        """Return the front as `prefplan front` prints it: a table, and the actions of each plan."""
        table = ["\n".join([self.title, in_columns(self.table), *self.notes])] if self.plans else []
        blocks = self.listing(lambda i: f"`print(front[{i}])` prints all")
        return "\n\n".join([*table, *blocks, *([self.missing] if self.missing else [])])

    def _repr_html_(self) -> str:
        """Return the front as HTML for notebooks: a row for each plan, and why it is empty or incomplete."""
        head, *rows = self.table
        body = "".join(_row("td", row) for row in rows)
        table = f"<table><thead>{_row('th', ['', *head[1:]])}</thead><tbody>{body}</tbody></table>" if rows else ""
        return table + (f"<p>{escape(self.missing)}</p>" if self.missing else "")

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.plans)

    @overload
    def __getitem__(self, index: int) -> Plan: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Plan, ...]: ...

    def __getitem__(self, index: int | slice) -> Plan | tuple[Plan, ...]:
        """Return a plan by its number, or several."""
        try:
            return self.plans[index]  # type: ignore[return-value]
        except IndexError:
            raise IndexError(f"plan {index}: the front has {len(self)}, counted from 0") from None


def _row(tag: str, cells: Iterable[object]) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(str(cell))}</{tag}>' for cell in cells)}</tr>"
