"""Random problems with their small numbers replaced by numbers in every style that users write."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from typing import Any

from judge.preferences import Number, exact
from judge.problems import GraphProblem

Written = int | float | Decimal

STYLES: dict[str, Callable[[random.Random, int], Written]] = {
    "small": lambda rng, number: number,
    "decimal": lambda rng, number: Decimal(number * 1000 + rng.choice((0, 5, 125, 999))) / 1000,
    "float": lambda rng, number: number * rng.choice((0.37454011884736254, 0.9507143064099162, 1.0)),
    "tiny": lambda rng, number: Decimal(number).scaleb(-8),
    "huge": lambda rng, number: number * 10**15 + rng.choice((0, 0, 1)) * (number > 0),
    "zero": lambda rng, number: rng.choice((0, 0, 1)),
    "thirds": lambda rng, number: number / 3,
    "sums": lambda rng, number: number * 0.1 + 0.2 if number else 0,
}
"""How each style writes a number in place of a small whole one."""


def restyled(rng: random.Random, problem: GraphProblem, style: str) -> GraphProblem:
    """Return a problem with all its costs, prices, weights and deadlines in one style, or in `mixed` styles."""
    floats: dict[Number, float] = {}

    def write(number: Number) -> Number:
        name = rng.choice([s for s in STYLES if s not in ("tiny", "huge")]) if style == "mixed" else style
        written = STYLES[name](rng, int(number))
        value = exact(written)
        if isinstance(written, float):
            floats[value] = written
        return value

    def table(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {key: table(below) for key, below in value.items()}
        if isinstance(value, (list, tuple)):
            return [table(below) for below in value]
        return value if isinstance(value, str) else write(value)

    return replace(
        problem,
        edges=tuple(replace(edge, cost=write(edge.cost)) for edge in problem.edges),
        tasks=tuple(
            replace(
                task,
                relax=tuple(replace(entry, cost=write(entry.cost)) for entry in task.relax),
                skip=None if task.skip is None else write(task.skip),
            )
            for task in problem.tasks
        ),
        preference=table(problem.preference),
        floats=floats,
    )


def to_resolution(problem: GraphProblem, resolution: float) -> GraphProblem:
    """Return a problem whose costs that came from floats are rounded to multiples of a resolution."""
    step = Fraction(str(resolution))

    def rounded(number: Number) -> Number:
        return exact(round(Fraction(number) / step) * step) if number in problem.floats else number

    return replace(problem, edges=tuple(replace(edge, cost=rounded(edge.cost)) for edge in problem.edges))
