"""Small planning problems as plain data, and as a scenario file's content."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import cached_property
from typing import Any

from judge.preferences import Mu, Number, reference
from judge.semantics import Label
from judge.syntax import Formula, propositions_of, to_text


@dataclass(frozen=True)
class Edge:
    """One action of one state."""

    source: str
    action: str
    cost: Number
    target: str


@dataclass(frozen=True)
class Relaxation:
    """Permission to read labels where `when` holds as if `assume` held too, for `cost` each time (Remarks 1 to 6)."""

    assume: str
    when: Formula
    cost: Number


@dataclass(frozen=True)
class JudgedTask:
    """A task; `skip` is the price of skipping it, None if it may not be skipped."""

    name: str
    formula: Formula
    relax: tuple[Relaxation, ...] = ()
    skip: Number | None = None


@dataclass(frozen=True, eq=False)
class GraphProblem:
    """An explicit graph, tasks, and a preference; costs in the user's units, exact. Hashed by identity.

    Attributes:
        start: the first state.
        edges: every action; those of a state in order.
        labels: the propositions of each state that has any.
        tasks: the tasks, in order.
        preference: the `[preference]` table of the scenario.
        bygone: states in which no plan ends.
        floats: the floats that a scenario has in place of some exact numbers.
    """

    start: str
    edges: tuple[Edge, ...]
    labels: Mapping[str, Label]
    tasks: tuple[JudgedTask, ...]
    preference: Mapping[str, Any] = field(default_factory=lambda: {"kind": "order"})
    bygone: frozenset[str] = frozenset()
    floats: Mapping[Number, float] = field(default_factory=dict)

    @cached_property
    def outgoing(self) -> dict[str, list[Edge]]:
        """The edges of each state that has any."""
        table: dict[str, list[Edge]] = {}
        for edge in self.edges:
            table.setdefault(edge.source, []).append(edge)
        return table

    @property
    def names(self) -> tuple[str, ...]:
        """The tasks' names."""
        return tuple(task.name for task in self.tasks)

    def label(self, state: str) -> Label:
        """Return L(state)."""
        return self.labels.get(state, frozenset())

    def mu(self) -> Mu:
        """Return the reference preference function."""
        return reference(self.preference, self.names)

    def scenario(self) -> dict[str, Any]:
        """Return the content of a scenario file with `kind = "graph"`; an action named like its target is left out."""
        used: set[str] = set()
        for task in self.tasks:
            used |= propositions_of(task.formula)
            for entry in task.relax:
                used |= {entry.assume} | propositions_of(entry.when)
        transitions = []
        for edge in self.edges:
            action = {} if edge.action == edge.target else {"action": edge.action}
            transitions.append({"from": edge.source, "to": edge.target, **action, "cost": self._written(edge.cost)})
        model = {
            "kind": "graph",
            "start": self.start,
            "propositions": sorted(used - frozenset().union(*self.labels.values())),
            "transitions": transitions,
            "labels": {state: sorted(label) for state, label in self.labels.items()},
        }
        return {
            "model": model,
            "tasks": [self._task_table(task) for task in self.tasks],
            "preference": self._table(self.preference),
        }

    def _task_table(self, task: JudgedTask) -> dict[str, Any]:
        table: dict[str, Any] = {"name": task.name, "formula": to_text(task.formula)}
        if task.relax:
            table["relax"] = [
                {"assume": entry.assume, "when": to_text(entry.when), "cost": self._written(entry.cost)}
                for entry in task.relax
            ]
        if task.skip is not None:
            table["skip"] = self._written(task.skip)
        return table

    def _table(self, value: Any) -> Any:
        """Return a table of a scenario with its numbers as a file would hold them."""
        if isinstance(value, Mapping):
            return {key: self._table(below) for key, below in value.items()}
        if isinstance(value, (list, tuple)):
            return [self._table(below) for below in value]
        return self._written(value) if isinstance(value, (int, Fraction)) else value

    def _written(self, number: Number) -> int | float | Decimal:
        """Return a number as a scenario file would hold it: a decimal, unless a float stands for it."""
        if number in self.floats:
            return self.floats[number]
        if not isinstance(number, Fraction):
            return number
        with localcontext(prec=100):
            return Decimal(number.numerator) / Decimal(number.denominator)


def grid_problem(
    size: Sequence[int],
    start: Sequence[int],
    regions: Mapping[str, Sequence[int]],
    tasks: Sequence[JudgedTask],
    preference: Mapping[str, Any],
) -> GraphProblem:
    """Lay a problem out on a grid of unit costs: actions N, S, E, W, (0, 0) lower left, box corners inclusive."""
    moves = {"N": (0, 1), "S": (0, -1), "E": (1, 0), "W": (-1, 0)}
    cells = {(x, y): f"{x},{y}" for x in range(size[0]) for y in range(size[1])}
    edges = [
        Edge(name, action, 1, cells[x + dx, y + dy])
        for (x, y), name in cells.items()
        for action, (dx, dy) in moves.items()
        if (x + dx, y + dy) in cells
    ]
    labels = {
        name: frozenset(region for region, (x0, y0, x1, y1) in regions.items() if x0 <= x <= x1 and y0 <= y <= y1)
        for (x, y), name in cells.items()
    }
    return GraphProblem(cells[start[0], start[1]], tuple(edges), labels, tuple(tasks), preference)
