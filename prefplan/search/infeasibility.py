"""Why no plan satisfies all tasks: a smallest set of tasks, or of rules, that cannot be satisfied together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from typing import TypeVar

import numpy as np

from prefplan.errors import LimitError
from prefplan.front import Reason
from prefplan.heuristics.preprocessing import Options, Prepared
from prefplan.limits import Limits
from prefplan.logic.tasks import Rule, Task
from prefplan.preferences.kinds import WeightedSum
from prefplan.problem import Problem
from prefplan.product.generated_product import GeneratedProduct
from prefplan.product.product_automaton import Product
from prefplan.product.reduction import Reduction
from prefplan.search.bi_objective_search import BiObjectiveSearch

T = TypeVar("T")


def infeasible(reduction: Reduction, limits: Limits) -> Reason | None:
    """Return a smallest set of tasks or rules that cannot be satisfied together, or None if all of them can.

    Raises:
        LimitError: a limit was reached before that is known.
    """
    tasks, rules = reduction.problem.tasks, reduction.problem.rules
    if _is_satisfiable(reduction, limits, tasks, rules):
        return None
    if rules and _is_satisfiable(reduction, limits, tasks, ()):
        broken = next(few for few in _subsets(rules) if not _is_satisfiable(reduction, limits, tasks, few))
        return Reason("rule", tuple(rule.name for rule in broken))
    blame = next(few for few in _subsets(tasks) if not _is_satisfiable(reduction, limits, few, ()))
    return Reason("task" if len(blame) == 1 else "conflict", tuple(task.name for task in blame))


def _subsets(parts: Sequence[T]) -> Iterator[tuple[T, ...]]:
    """Yield the non-empty subsets, smaller ones first."""
    for size in range(1, len(parts) + 1):
        yield from combinations(parts, size)


def _is_satisfiable(reduction: Reduction, limits: Limits, tasks: tuple[Task, ...], rules: tuple[Rule, ...]) -> bool:
    """Return whether a plan satisfies these tasks, relaxed at any price, and keeps the rules that may not be broken."""
    nothing = WeightedSum({task.name: 0 for task in tasks}, over="violation")
    free = tuple(
        replace(task, relax=tuple(replace(r, cost=0) for r in task.relax), skip=None if task.skip is None else 0)
        for task in tasks
    )
    kept = tuple(rule for rule in rules if rule.skip is None)
    if isinstance(reduction.product, GeneratedProduct):
        product = reduction.product_of(
            Problem(reduction.problem.system, free, nothing, rules=kept, past=reduction.problem.past)
        )
    else:
        # Costs do not matter here.
        system = reduction.quotient.system
        system = replace(system, costs=np.zeros(len(system.costs), dtype=np.int64), more_costs=())
        product = Product(Problem(system, free, nothing, rules=kept, past=reduction.problem.past))
    search = BiObjectiveSearch(Prepared(product, Options(heuristic=1), single=True), cost_only=True)
    left = replace(limits, complete_below=0)
    found = next(search.goals(left), None) is not None
    if left.ended:
        raise LimitError(left.ended)
    return found
