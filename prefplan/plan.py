"""A plan, as a result for the user: in the user's names and units."""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any

from prefplan.exact_costs import Number
from prefplan.text.layout import number, numbered
from prefplan.text.names import DisplayNames

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
        """Return the text of `str` with other words, such as a label, in place of the name of the task or rule."""
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
        violation_costs: v_i, the price paid for relaxations, by name of each task and each rule that may be broken.
        actions: (K,) the actions, in order.
        states: (K + 1,) the trajectory.
        relaxations: the relaxations used, in order of steps.
        costs: every total cost by name; the first is `cost`.
        preferences: every mu by name; the first is `preference`.
        display: the labels that are shown in place of names.
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
    display: DisplayNames = field(default=DisplayNames(), repr=False, compare=False)

    def __hash__(self) -> int:
        """Return a hash of the cost, mu and the actions."""
        return hash((self.cost, self.preference, self.actions))

    @property
    def objectives(self) -> dict[str, Number]:
        """The plan's costs and preferences, by name."""
        return self.costs | self.preferences or dict(zip(PAIR, (self.cost, self.preference), strict=True))

    @property
    def steps(self) -> str:
        """The numbered actions, and an indented line for every relaxation that the plan uses."""
        return self.listing()

    def listing(self, *, most: int | None = None, whole: str = "") -> str:
        """Return `steps`, with at most `most` entries; arguments as in `prefplan.text.layout.numbered`."""
        actions = numbered(list(map(self.display.action, self.actions)), most=most, whole=whole)
        relaxed = [f"  {purchase.words(self.display.task(purchase.task))}" for purchase in self.relaxations]
        return "\n".join([actions or "(nothing to do)", *relaxed])

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


class OnDemand(Sequence[Any]):
    """A sequence whose entries are computed when they are read."""

    def __init__(self, length: int, make: Callable[[int], Any]) -> None:
        """Take the length, and a function that returns an entry."""
        self._length, self._make = length, make

    def __len__(self) -> int:
        """Return the length."""
        return self._length

    def __getitem__(self, index: Any) -> Any:
        """Return an entry, or the tuple of several."""
        at = range(self._length)[index]
        return self._make(at) if isinstance(at, int) else tuple(map(self._make, at))

    def __eq__(self, other: object) -> bool:
        """Return whether the entries are those of another sequence."""
        return isinstance(other, (tuple, OnDemand)) and tuple(self) == tuple(other)

    def __reduce__(self) -> tuple[type, tuple[tuple[Any, ...]]]:
        """Return what is pickled: the entries, since the function cannot be."""
        return tuple, (tuple(self),)
