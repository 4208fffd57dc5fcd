"""Which search suits a problem."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import partial

from prefplan.heuristics.prepare import Options, Prepared
from prefplan.limits import Limits
from prefplan.product.product_automaton import Product
from prefplan.search.driver import LabelSearch
from prefplan.search.incumbent import run_with_incumbent
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
    cost = problem.cost_names[0]
    # The front of one cost and one preference is found sooner than the least value of a preference.
    first = None if problem.is_bi_objective and objective != cost else objective
    # Some plan is looked for where any will do until there is a better one.
    is_free = problem.is_bi_objective and problem.measure.bi_objective and not bounds.keys() - {cost}
    prepared = Prepared(product, options, single=is_free and first == cost, max_bytes=limits.bytes)
    search = LabelSearch(prepared, bounds=bounds, first=first)
    return partial(run_with_incumbent, search) if is_free else search.run
