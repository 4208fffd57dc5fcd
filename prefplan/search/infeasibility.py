"""Why no plan satisfies all tasks: some tasks, or rules, that cannot be satisfied together, though any fewer can."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import chain, combinations
from typing import TypeVar

from prefplan.errors import LimitError
from prefplan.front import Reason
from prefplan.heuristics.prepare import Options
from prefplan.logic.tasks import Rule, Task
from prefplan.preferences.kinds import WeightedSum
from prefplan.problem import Problem
from prefplan.product.reduction import product_of
from prefplan.search.incumbent import run_search

T = TypeVar("T")


def infeasible(problem: Problem) -> Reason | None:
    """Return an irreducible set of tasks or rules that cannot be satisfied together, or None if all of them can.

    Raises:
        LimitError: a limit was reached before that is known.
    """
    tasks, rules = problem.tasks, problem.hard_rules
    is_satisfiable = partial(_is_satisfiable, problem)
    if is_satisfiable(tasks, rules):
        return None
    if rules and is_satisfiable(tasks):
        broken = _irreducible(rules, partial(is_satisfiable, tasks))
        return Reason("rule", tuple(rule.name for rule in broken))
    blame = _irreducible(tasks, is_satisfiable)
    return Reason("task" if len(blame) == 1 else "conflict", tuple(task.name for task in blame))


def _irreducible(parts: tuple[T, ...], is_satisfiable: Callable[[tuple[T, ...]], bool]) -> tuple[T, ...]:
    """Return some of the parts that cannot be satisfied together, though any fewer of them can.

    A single such part or a pair is found if there is one; else each part is removed if the rest remains unsatisfiable
    (deletion filter: J. W. Chinneck and E. W. Dravnieks, "Locating minimal infeasible constraint sets in linear
    programs", ORSA Journal on Computing 1991).
    """
    for few in chain(combinations(parts, 1), combinations(parts, 2)):
        if not is_satisfiable(few):
            return few
    kept = parts
    for part in parts:
        rest = tuple(other for other in kept if other is not part)
        if not is_satisfiable(rest):
            kept = rest
    return kept


def _is_satisfiable(problem: Problem, tasks: tuple[Task, ...], rules: tuple[Rule, ...] = ()) -> bool:
    """Return whether a plan satisfies these tasks, relaxed at any price, and keeps these rules."""
    nothing = WeightedSum({task.name: 0 for task in tasks}, over="violation")
    free = tuple(
        replace(task, relax=tuple(replace(r, cost=0) for r in task.relax), skip=None if task.skip is None else 0)
        for task in tasks
    )
    fewer = Problem(problem.system, free, nothing, rules=rules, past=problem.past)
    result = run_search(product_of(fewer), Options(heuristic=1), {}, fewer.cost_names[0])
    if result.ended is not None:
        raise LimitError(result.ended)
    return bool(result.goals)
