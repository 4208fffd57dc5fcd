"""Planners that go about it in other ways than the default one, for tests: their plans must be as good."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import partial
from typing import TypeAlias

from prefplan import Front, Options, Planner, Problem
from prefplan.product.product_automaton import Product
from prefplan.product.reduction import GeneratedProduct, ReducedProduct, product_of
from prefplan.search.paths import Result
from prefplan.search.reference import ReferenceSearch

PlannerOf: TypeAlias = Callable[[Problem], Planner]


class ReferencePlanner(Planner):
    """Searches in plain Python, with unbounded integers."""

    @staticmethod
    def _search(product: Product, options: Options, bounds: Mapping[str, Fraction], objective: str | None) -> Result:
        if isinstance(product, GeneratedProduct):
            product = ReducedProduct(product.problem, product.model)
        single = product.problem.is_bi_objective and objective == product.problem.cost_names[0]
        return ReferenceSearch(product, bounds=bounds, single=single).run()


class ListedPlanner(Planner):
    """Lists the states of models however large they are."""

    def _solve(self, objective: str | None, bounds: Mapping[str, Fraction]) -> Front:
        if self._product is None:
            self._product = product_of(self._ahead)
        if isinstance(self._product, GeneratedProduct):
            self._product = ReducedProduct(self._ahead, self._product.model)
        return super()._solve(objective, bounds)


PLANNERS: tuple[PlannerOf, ...] = (
    Planner,
    partial(Planner, options=Options(heuristic=0, preference_bound=False, contraction=False)),
    partial(Planner, options=Options(heuristic=1, contraction=False)),
    partial(Planner, options=Options(heuristic=2, preference_bound=False)),
    partial(Planner, options=Options(heuristic=3, contraction=False)),
    ReferencePlanner,
)
"""A front must not depend on which of these finds it."""
