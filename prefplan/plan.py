"""A plan, as a result for the user: in the user's names and units."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from io import StringIO
from itertools import accumulate
from operator import ge
from typing import TYPE_CHECKING, cast, overload

from prefplan.drawing import Cell, draw_map, draw_timeline
from prefplan.exact_costs import Number, exact, to_number
from prefplan.text.layout import number, numbered
from prefplan.text.names import DisplayNames

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from prefplan.models.grid import GridModel

PAIR = ("cost", "preference")
"""Default names of one cost and one preference."""


@dataclass(frozen=True)
class Purchase:
    """A relaxation that a plan uses.

    Attributes:
        task: name of the task that is relaxed or skipped, or of the rule that is broken.
        step: number of actions before the label that is relaxed, or that breaks the rule; 0 for a skipped task.
        assume: proposition that was assumed to hold; None if the task was skipped or the rule broken.
        cost: its price.
        rule: whether a rule is broken.
    """

    task: str
    step: int
    assume: str | None
    cost: Number
    rule: bool = field(default=False, repr=False)

    def __str__(self) -> str:
        """Return what is relaxed, when and for what price."""
        return self.words(self.task)

    def words(self, task: str) -> str:
        """Return the same with what is shown for the task or rule in place of its name."""
        when = f"after action {self.step}" if self.step else "at the start"
        if self.rule:
            return f"the rule {task} is broken {when}, for {number(self.cost)}"
        if self.assume is None:
            return f"{task} is skipped, for {number(self.cost)}"
        return f"{task} assumes {self.assume} {when}, for {number(self.cost)}"


@dataclass(frozen=True)
class Plan:
    """A plan that satisfies all tasks, as far as they are not relaxed.

    Attributes:
        cost: total cost (equation 1).
        preference: mu (Definition 5).
        task_costs: c_i by task name (equation 2); the whole plan's cost for a task that is never satisfied.
        violation_costs: v_i by task name: what was paid to relax it; also by name of each rule that may be broken.
        actions: (K,) the actions, in order.
        states: (K + 1,) the trajectory.
        relaxations: the relaxations used, in order of steps.
        costs: every total cost by name; the first is `cost`.
        preferences: every mu by name; the first is `preference`.
        action_costs: (K,) first cost of each action.
        map: of the grid on which it moves; None for other models.
        display: what people are shown in place of names.
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
    action_costs: tuple[Number, ...] = field(default=(), compare=False)
    map: GridModel | None = field(default=None, repr=False, compare=False)
    display: DisplayNames = field(default=DisplayNames(), repr=False, compare=False)

    @property
    def objectives(self) -> dict[str, Number]:
        """The plan's costs and preferences, by name."""
        return self.costs | self.preferences or dict(zip(PAIR, (self.cost, self.preference), strict=True))

    @property
    def steps(self) -> str:
        """The numbered actions, and an indented line for every relaxation that the plan uses."""
        return self.listing()

    def listing(self, *, most: int | None = None, whole: str = "") -> str:
        """Return `steps`, with at most some of the actions; arguments as in `prefplan.text.layout.numbered`."""
        actions = numbered(list(map(self.display.action, self.actions)), most=most, whole=whole)
        relaxed = [f"  {purchase.words(self.display.task(purchase.task))}" for purchase in self.relaxations]
        return "\n".join([actions or "(nothing to do)", *relaxed])

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the plan on the map of its grid, or else as a timeline along its cost, on axes or a new figure."""
        if ax is None:
            from matplotlib.figure import Figure

            width, height = self.map.size if self.map else (9.0, 3.5)
            scale = min(0.8, 5.5 / max(width, height)) if self.map else 1.0
            ax = Figure(figsize=(scale * width, scale * height), layout="constrained").add_subplot()
        costs = self.action_costs or (to_number(exact(self.cost) / max(1, len(self.actions))),) * len(self.actions)
        satisfied = {
            self.display.task(name): None if name in self._skipped else cost for name, cost in self.task_costs.items()
        }
        ax.set_title(objectives_text(self), loc="left", fontsize="medium")
        if self.map is None:
            draw_timeline(
                ax, [*map(self.display.action, self.actions)], costs, satisfied, cost=next(iter(self.objectives))
            )
            return ax
        spent = [*accumulate(map(exact, costs), initial=Fraction(0))]
        done = {name: bisect_left(spent, exact(cost)) for name, cost in satisfied.items() if cost is not None}
        draw_map(ax, self.map, cast(Sequence[Cell], self.states), done)
        return ax

    def _repr_svg_(self) -> str:
        """Return `plot` as SVG for notebooks."""
        picture = StringIO()
        cast("Figure", self.plot().figure).savefig(picture, format="svg", bbox_inches="tight")
        return picture.getvalue()

    @property
    def _skipped(self) -> set[str]:
        """The tasks that are skipped."""
        return {purchase.task for purchase in self.relaxations if purchase.assume is None and not purchase.rule}

    def __str__(self) -> str:
        """Return the plan as `prefplan plan` prints it: its costs, when each task is satisfied, and its actions."""
        counted = next(iter(self.objectives))
        lines = [objectives_text(self)]
        for name, cost in self.task_costs.items():
            what = "not satisfied" if name in self._skipped else f"satisfied at {counted} {number(cost)}"
            lines.append(f"  {self.display.task(name)} {what}")
        return "\n".join([*lines, self.steps])


def objectives_text(plan: Plan, *, penalty: str = "penalty") -> str:
    """Return the objectives of a plan in words; `penalty` is what a preference without a name is called."""
    called = {PAIR[1]: penalty}
    return ", ".join(f"{called.get(name, name)} {number(value)}" for name, value in plan.objectives.items())


def point_of(plan: Plan) -> tuple[Number, ...]:
    """Return the values of a plan's objectives."""
    return tuple(plan.objectives.values())


class Plans(Sequence[Plan]):
    """The plans of a front, each made when it is first read.

    Attributes:
        points: the values of their objectives.
    """

    def __init__(self, points: Sequence[tuple[Number, ...]], make: Sequence[Callable[[], Plan]]) -> None:
        """Take the points, and for each a function that makes the plan."""
        self.points, self._make, self._made = points, make, dict[int, Plan]()

    @classmethod
    def of(cls, plans: Sequence[Plan]) -> Plans:
        """Return plans, which may have been made before."""
        if isinstance(plans, Plans):
            return plans
        return cls([*map(point_of, plans)], [partial(plans.__getitem__, k) for k in range(len(plans))])

    def undominated(self, columns: Sequence[int]) -> Plans:
        """Return the plans that no other one dominates in some of the objectives; of equal ones the first."""
        values = [tuple(point[column] for column in columns) for point in self.points]
        first = dict(zip(reversed(values), reversed(range(len(values))), strict=True))
        kept = [k for one, k in first.items() if not any(other != one and all(map(ge, one, other)) for other in first)]
        return Plans([self.points[k] for k in sorted(kept)], [partial(self.__getitem__, k) for k in sorted(kept)])

    def __len__(self) -> int:
        """Return the number of plans."""
        return len(self.points)

    @overload
    def __getitem__(self, index: int) -> Plan: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Plan, ...]: ...

    def __getitem__(self, index: int | slice) -> Plan | tuple[Plan, ...]:
        """Return a plan by its number, or several."""
        number = range(len(self))[index]
        if isinstance(number, range):
            return tuple(self[k] for k in number)
        if number not in self._made:
            self._made[number] = self._make[number]()
        return self._made[number]
