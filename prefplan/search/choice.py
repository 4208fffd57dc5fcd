"""Which search suits a problem."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import partial

from prefplan.errors import LimitError
from prefplan.heuristics.prepare import Options, Prepared, bytes_to_prepare
from prefplan.limits import Limits
from prefplan.models.kernels import compile_kernels
from prefplan.product.product_automaton import Product
from prefplan.search.boa_star import BiObjectiveSearch
from prefplan.search.incumbent import run_cheapest, run_with_incumbent
from prefplan.search.result import Result


def choose_search(
    product: Product, options: Options, limits: Limits, bounds: Mapping[str, Fraction], objective: str | None
) -> Callable[[Limits], Result]:
    """Return the compiled search that suits a problem.

    Its tables must fit the limits. Bounds are inclusive. Without an `objective`, the front is wanted.

    Raises:
        LimitError: a limit was reached.
        OverflowError: a number might not fit 64 bits.
    """
    problem = product.problem
    if len(problem.cost_names) * bytes_to_prepare(product) > limits.bytes:
        raise LimitError("memory")
    if not (problem.is_bi_objective and problem.measure.bi_objective):
        # The front of one cost and one preference is found sooner than the least value of a preference.
        first = None if problem.is_bi_objective and objective != problem.cost_names[0] else objective
        compile_kernels()
        # Most searches do without its modules.
        from prefplan.search.multi_objective.objective_search import ObjectiveSearch

        return ObjectiveSearch(product, options, bounds=bounds, first=first, max_bytes=limits.bytes).run
    cost, preference = problem.objective_names
    single, max_mu = objective == cost, bounds.get(preference)
    max_cost = math.floor(bounds[cost] / problem.units.cost) if cost in bounds else math.inf
    prepared = Prepared(product, options, max_bytes=limits.bytes)
    if single and max_mu is None:
        return partial(run_cheapest, prepared, max_cost)
    search = BiObjectiveSearch(prepared, max_mu=max_mu, max_cost=max_cost, single=single)
    return search.run if max_mu is not None else partial(run_with_incumbent, search)
