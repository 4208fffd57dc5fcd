"""Preferences of one's own: expressions beside other terms, and Python functions, against the judges."""

from __future__ import annotations

import random
from dataclasses import replace
from functools import partial
from typing import Any

import judge
import pytest
from judge.preferences import EXPRESSIONS, named, random_preference, reference
from judge.verdict import exact_limit, verdict

from prefplan import Expression, Function, Options, Planner, Problem, Task, TransitionSystem
from prefplan.scenario.decode import from_dict


def drawn(seed: int, *, beside: bool) -> judge.GraphProblem:
    """Return a random problem with an expression, alone or beside one or two other terms."""
    problem, rng = judge.random_problem(seed, kind="expression"), random.Random(seed)
    if not beside:
        return problem
    names = problem.names
    terms = [random_preference(rng, names, rng.choice(("order", "max", "deadline"))) for _ in range(rng.choice((1, 2)))]
    text = named(rng.choice(list(EXPRESSIONS)), rng.sample(list(names), len(names)))
    terms.append({"kind": "expression", "expression": text})
    table = {"kind": "sum", "terms": [{**term, "weight": rng.choice((1, 2, 3))} for term in terms]}
    return replace(problem, preference=table)


@pytest.mark.parametrize("seeds", [range(12), range(12, 24)], ids=lambda seeds: str(seeds[0]))
def test_fronts_of_expressions_beside_other_terms_are_those_of_the_judges(seeds: range) -> None:
    planners = Planner, partial(Planner, options=Options(contraction=False))
    outcomes = {seed: verdict(drawn(seed, beside=True), planners) for seed in seeds}
    assert {seed: wrong for seed, wrong in outcomes.items() if wrong} == {}


def points(problem: Problem, **bounds: Any) -> list[tuple[Any, Any]]:
    return [(plan.cost, plan.preference) for plan in Planner(problem).front(**bounds)]


@pytest.mark.parametrize("seed", range(12))
def test_a_function_has_the_front_of_the_expression_that_it_computes(seed: int) -> None:
    beside = seed % 3 == 0
    judged = drawn(seed, beside=beside)
    problem, mu = from_dict(judged.scenario()).problem(), reference(judged.preference, judged.names)
    # Beside other terms, the contract of the expression is not that of the sum.
    contract = "general" if beside else problem.measure.contract
    same = Function(lambda costs, paid: float(mu(tuple(costs.tolist()), tuple(paid.tolist()))), contract)
    limit = float(exact_limit(judged) or 40)
    assert points(Problem(problem.system, problem.tasks, same), max_cost=limit) == [
        (cost, pytest.approx(preference, rel=1e-9)) for cost, preference in points(problem, max_cost=limit)
    ]


def test_a_detour_that_pays_may_have_more_actions_than_the_product_has_states() -> None:
    steps = [("s", "wait", "s", 3), ("s", "go", "t", 2), ("t", "go", "u", 1)]
    system = TransitionSystem.from_transitions(steps, start="s", labels={"t": ["b"], "u": ["c"]})
    problem = Problem(system, [Task("x", "F c"), Task("y", "F b")], Expression("max(0, x - y) / (1 + y)"))
    assert points(problem, max_cost=300) == [(3 + 3 * k, pytest.approx(1 / (3 + 3 * k))) for k in range(100)]
