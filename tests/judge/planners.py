"""Planners that go about it in other ways than the default one, for tests: their plans must be as good."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TypeAlias

from prefplan import Options, Planner, Problem

PlannerOf: TypeAlias = Callable[[Problem], Planner]


class ReferencePlanner(Planner):
    """Searches in plain Python, with unbounded integers."""

    _search = Planner._search_in_python


class ListedPlanner(Planner):
    """Lists the states of models however large they are."""

    def __init__(self, problem: Problem) -> None:
        """Take the problem."""
        super().__init__(problem)
        listed = partial(self._reduction.product_of, listed=True)
        self._reduction.product_of = listed  # type: ignore[method-assign]


PLANNERS: tuple[PlannerOf, ...] = (
    Planner,
    partial(Planner, options=Options(heuristic=0, preference_bound=False, contraction=False)),
    partial(Planner, options=Options(heuristic=1, contraction=False)),
    partial(Planner, options=Options(heuristic=2, preference_bound=False)),
    partial(Planner, options=Options(heuristic=3, contraction=False)),
    ReferencePlanner,
)
"""A front must not depend on which of these finds it."""
