"""Compiled searches against the reference search: the same fronts, whatever a problem prefers, costs and forbids."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import judge
import numpy as np
import pytest
from judge.fuzz import draw
from judge.planners import ReferencePlanner
from judge.several import bounds_of, random_several
from judge.verdict import exact_limit

from prefplan import Expression, Function, Planner, Preference, Problem
from prefplan.preferences import contracts
from prefplan.scenario.decode import from_dict

KINDS = ("one preference", "several objectives", "rules", "own expression", "Python function")
"""What the problem of a number is about; one preference has nine kinds, and seven styles of numbers (`judge.fuzz`)."""

NO_PLAN_BOUND = 30
"""Largest cost of plans of a problem of which a judge knows that there is none."""

Drawn = tuple[Problem, dict[str, Any]]


def _several(seed: int) -> Drawn:
    several = random_several(seed)
    problem = from_dict(several.scenario()).problem()
    bounds = bounds_of(several)
    return problem, dict.fromkeys(problem.cost_names, NO_PLAN_BOUND) if bounds is None else dict(bounds)


def _one(seed: int) -> Drawn:
    errands = judge.random_errands(seed, ("order", "weighted-sum", "deadline")[seed % 3])
    drawn = errands if seed % 2 else draw(seed)[1]
    problem = from_dict(drawn.scenario()).problem()
    return problem, {problem.cost_names[0]: exact_limit(drawn) or NO_PLAN_BOUND}


def _ruled(seed: int) -> Drawn:
    """Return a problem with rules, some of which may be broken for a price."""
    rng = random.Random(f"reference {seed}")
    drawn = judge.random_errands(seed, "order")
    if seed % 3 == 0:
        drawn = judge.random_problem(seed, kind="weighted-sum", relaxed=True)
    data = drawn.scenario()
    data["model"]["propositions"] = sorted(set("abcde") - frozenset().union(*drawn.labels.values()))
    shapes = ("G !{0}", "!{0} W {1}", "G ({0} -> X !{1})", "G ({0} -> G[1,2] !{1})")
    data["rules"] = [{"name": f"r{k}", "formula": rng.choice(shapes).format(*rng.sample("abcde", 2))} for k in range(3)]
    for rule in data["rules"][:2]:
        rule["skip"] = rng.choice((1, 2, 4))
    weights = {name: rng.choice((0, 1, 2)) for name in (*drawn.names, "r0", "r1")}
    violations = {"kind": "weighted-sum", "over": "violation", "weights": weights, "weight": 1}
    data["preference"] = {"kind": "sum", "terms": [violations, {"kind": "order", "weight": rng.choice((1, 3))}]}
    return from_dict(data).problem(), {"cost": exact_limit(drawn) or NO_PLAN_BOUND}


def _with(preference: Callable[[Sequence[str], int], Preference]) -> Callable[[int], Drawn]:
    def drawn(seed: int) -> Drawn:
        graph = judge.random_errands(seed, "order") if seed % 4 else judge.random_problem(seed)
        problem = from_dict(graph.scenario()).problem()
        own = Problem(problem.system, problem.tasks, preference(problem.names, seed))
        return own, {"cost": exact_limit(graph) or NO_PLAN_BOUND}

    return drawn


EXPRESSIONS = (
    "{0} * {1}",
    "max({0}, {1}) + 2 * {0}",
    "min({0}, 4) + {1}",
    "{0} / 3 + max({0} - 2, {1})",
    "({0} + 1) * ({1} + {0}) / 7",
)


def _product(costs: np.ndarray, violations: np.ndarray) -> float:
    return float(np.prod(1 + costs / 7))


def _capped(costs: np.ndarray, violations: np.ndarray) -> float:
    return float(np.sum(np.minimum(costs, 5)) + np.sqrt(costs.max()))


def _expression(names: Sequence[str], seed: int) -> Preference:
    return Expression(EXPRESSIONS[seed % len(EXPRESSIONS)].format(*names))


def _function(names: Sequence[str], seed: int) -> Preference:
    return Function((_product, _capped)[seed % 2], ("componentwise", "general")[seed // 2 % 2])


DRAWN: dict[str, Callable[[int], Drawn]] = dict(
    zip(KINDS, (_one, _several, _ruled, _with(_expression), _with(_function)), strict=True)
)


def fronts(number: int) -> tuple[list[tuple[Any, ...]], list[tuple[Any, ...]]]:
    """Return the objectives of the front of a number's problem, as found by compiled search and by the reference."""
    problem, bounds = DRAWN[KINDS[number % len(KINDS)]](number // len(KINDS))
    both = []
    for planner in (Planner, ReferencePlanner):
        front = planner(problem).front(at_most=bounds)
        assert front.complete, number
        both.append([tuple(plan.objectives.values()) for plan in front])
    return both[0], both[1]


@pytest.mark.slow
@pytest.mark.parametrize("kind", range(len(KINDS)), ids=KINDS)
def test_compiled_searches_find_the_fronts_of_the_reference(kind: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Preferences in floating point are equal within 1e-9."""
    monkeypatch.setattr(contracts, "TRIALS", 8)  # the contracts hold; to try them takes longer than all searches
    sizes = Counter[int]()
    for number in range(kind, 300, len(KINDS)):
        compiled, reference = fronts(number)
        assert compiled == [pytest.approx(point, rel=1e-9, abs=1e-9) for point in reference], number
        sizes[len(reference)] += 1
    assert sizes[1] >= 5 and sum(count for size, count in sizes.items() if size > 1) >= 5
