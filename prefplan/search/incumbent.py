"""The search that suits a problem, with weighted A* beside it, which finds some plan in case a limit ends the search.

The exact search and weighted A* take turns until the exact search has a plan; when neither finds one, both may expand
twice as many labels. If the exact search finds its first goal early, as it mostly does, weighted A* never runs.
"""

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction

from prefplan.errors import LimitError
from prefplan.front import Stats
from prefplan.heuristics.prepare import Options, Prepared
from prefplan.product.product_automaton import Product
from prefplan.product.reduction import GeneratedProduct, ReducedProduct
from prefplan.search.driver import LabelSearch
from prefplan.search.paths import Goal, Result, ended_by
from prefplan.search.reference import ReferenceSearch

FIRST_EXPANDED = 100_000
"""Labels expanded in the first turn, about 0.5 s; most plans of 14 tasks are found with fewer."""

WEIGHTS = (1.0, 0.5, 0.45, 0.4, 0.35, 0.3)
"""Weights of the sum of the tasks' own costs-to-go. With 1 the search heads straight for a plan; with smaller ones it
finds better plans, since tasks share paths."""


def run_search(product: Product, options: Options, bounds: Mapping[str, Fraction], objective: str | None) -> Result:
    """Search a product within inclusive bounds and the present limits; for the front if `objective` is None.

    The search is compiled, or `ReferenceSearch` where a number might not fit 64 bits.

    Raises:
        LimitError: a limit was reached before the search began.
    """
    problem = product.problem
    cost = problem.cost_names[0]
    # The front of one cost and one preference is found sooner than the least value of a preference.
    first = None if problem.is_bi_objective and objective != cost else objective
    # Weighted A* is used where any plan is better than none: no objective but the cost is bounded.
    is_free = problem.is_bi_objective and problem.measure.bi_objective and not bounds.keys() - {cost}
    try:
        prepared = Prepared(product, options, single=is_free and first == cost)
        search = LabelSearch(prepared, bounds=bounds, first=first)
        return _run_with_incumbent(search) if is_free else search.run()
    except OverflowError:
        if isinstance(product, GeneratedProduct):
            product = ReducedProduct(problem, product.model)
        return ReferenceSearch(product, bounds=bounds, single=problem.is_bi_objective and first == cost).run()


def _run_with_incumbent(search: LabelSearch) -> Result:
    """Run a search; while it has no goal, look for plans that need not be best, each cheaper than the one before."""
    expanded, weights, cost = FIRST_EXPANDED, list(WEIGHTS), search.problem.cost_names[0]
    prepared: Prepared | None = None
    drafts, bounds, work = tuple[Goal, ...](), search.bounds, Stats()
    result = search.run(most_expanded=expanded)
    try:
        while weights and not (result.goals or result.ended or search.is_done):
            options = replace(search.prepared.options, heuristic=1, preference_bound=False)
            prepared = prepared or Prepared(search.product, options)
            guided = LabelSearch(prepared.guided(weights[0]), bounds=bounds, first=cost, hasty=True)
            draft = guided.run(most_expanded=expanded)
            work += draft.work
            if draft.ended is not None:
                raise LimitError(draft.ended)
            if found := draft.goals[-1:]:
                drafts, bounds = found, {cost: found[0].objectives[0] - search.problem.cost_units[0]}
            if found or guided.is_done:
                weights.pop(0)
            else:
                expanded *= 2
                result = search.run(most_expanded=expanded)
        if result.ended is None and not search.is_done:
            result = search.run()
    except (LimitError, KeyboardInterrupt) as error:
        result = replace(result, ended=ended_by(error))
    return replace(result, goals=result.goals or drafts, work=work + result.work)
