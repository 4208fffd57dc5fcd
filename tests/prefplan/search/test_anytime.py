"""Whatever is claimed of a plan or front when the search is stopped is true, at any time; judged by exact fronts."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import judge
import pytest
from judge.verdict import beyond, misjudged
from random_manipulation import random_problem

from prefplan import Options, Planner, UnfinishedError, pareto_front
from prefplan import planner as planner_module
from prefplan.anytime.beam import beam_search
from prefplan.errors import LimitError
from prefplan.heuristics.preprocessing import Prepared
from prefplan.limits import Limits
from prefplan.scenario.decode import from_dict
from prefplan.search.bi_objective_search import BiObjectiveSearch

GUIDED = Options(guided_tasks=1, drafted_tasks=1, beam_widths=(1, 2), first_expanded=2, pops=1)
"""The search for few tasks is guided too, and widens its beam after few labels."""


def stop_after(looks: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the time be up when the clock was looked at so often."""
    seen: list[Limits] = []

    def out_of_time(limits: Limits) -> bool:
        seen.append(limits)
        return len(seen) > looks

    monkeypatch.setattr(Limits, "out_of_time", property(out_of_time))


def problems() -> list[Any]:
    return [judge.random_errands(seed, "order") for seed in range(3)] + [
        judge.random_problem(seed, kind="order", tasks=3, relaxed=False) for seed in range(6)
    ]


def test_a_guided_search_finds_what_the_exact_one_finds() -> None:
    for problem in problems():
        planned = from_dict(problem.scenario(), name="problem").problem()
        front = pareto_front(planned, options=GUIDED, max_cost=100)
        if front:
            plan = Planner(planned, options=GUIDED).cheapest()
            assert (plan.cost, plan.preference) == (front[0].cost, front[0].preference)
            assert misjudged(problem, plan) is None


def test_a_guided_search_of_a_model_without_landmarks_finds_what_the_exact_one_finds() -> None:
    for seed in range(12):
        problem = random_problem(random.Random(seed), large=True)
        front = pareto_front(problem)
        if front:
            plan = Planner(problem, options=GUIDED).cheapest()
            assert (plan.cost, plan.preference) == (front[0].cost, front[0].preference)


def test_a_stopped_search_for_a_plan_proves_no_more_than_is_so() -> None:
    known = 0
    for problem in problems():
        planned = from_dict(problem.scenario(), name="problem").problem()
        front = pareto_front(planned, options=GUIDED, max_cost=100)
        for looks in (0, 3, 9, 20, 60) if front else ():
            with pytest.MonkeyPatch.context() as patch:
                stop_after(looks, patch)
                try:
                    plan, within = Planner(planned, options=GUIDED).cheapest(max_seconds=60), 0
                except UnfinishedError as error:
                    assert (error.complete_below or 0) <= front[0].cost
                    plan, within = error.best, error.within
            if plan is not None:
                known += 1
                assert misjudged(problem, plan) is None
                if within is not None:
                    assert front[0].cost <= plan.cost <= front[0].cost * (1 + within / 100) * (1 + 1e-12)
    assert known > 10


@pytest.mark.parametrize("within", [0, 40])
def test_a_stopped_front_has_plans_beyond_and_proves_no_more_than_is_so(within: int) -> None:
    proven = 0
    for problem in (*problems(), judge.random_errands(0, "max"), judge.random_errands(0, "expression")):
        planned = from_dict(problem.scenario(), name="problem").problem()
        exact = pareto_front(planned, options=GUIDED, max_cost=100)
        expected = [(judge.exact(plan.cost), judge.exact(plan.preference)) for plan in exact]
        for looks in (10, 20, 30, 40, 55) if exact else ():
            with pytest.MonkeyPatch.context() as patch:
                stop_after(looks, patch)
                front = pareto_front(planned, within=within, options=GUIDED, max_cost=100)
            assert all(misjudged(problem, plan) is None for plan in front)
            below = 0 if within or front.complete_below is None else front.complete_below
            points = [(plan.cost, plan.preference) for plan in front]
            assert front.complete or all((plan.cost, plan.preference) in points for plan in exact if plan.cost < below)
            if front.ended and front.within is not None:
                proven += 1
                assert beyond(front, expected, Fraction(str(front.within))) is None
    assert proven > 3


def test_a_front_stopped_before_its_search_begins_has_a_gap_too() -> None:
    def stopped(*_: Any, **__: Any) -> None:
        raise LimitError("time")

    proven = 0
    for problem in problems():
        planned = from_dict(problem.scenario(), name="problem").problem()
        exact = pareto_front(planned, options=GUIDED, max_cost=100)
        expected = [(judge.exact(plan.cost), judge.exact(plan.preference)) for plan in exact]
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(planner_module, "Prepared", stopped)
            front = pareto_front(planned, options=GUIDED, max_cost=100)
        assert front.ended == "time" and all(misjudged(problem, plan) is None for plan in front)
        if front.within is not None:
            proven += 1
            assert beyond(front, expected, Fraction(str(front.within))) is None
    assert proven > 3


def test_a_wide_beam_follows_every_way() -> None:
    for problem in problems():
        planned = from_dict(problem.scenario(), name="problem").problem()
        front = pareto_front(planned, options=GUIDED, max_cost=100)
        planner = Planner(planned, options=GUIDED)
        light = Prepared(planner._product, Options(heuristic=1, preference_bound=False), single=True)
        search = BiObjectiveSearch(light.for_beams(), cost_only=True)
        found = beam_search(search, 10**6, 10**9)
        assert (found and found.plan.cost) == (front[0].cost if front else None)
        assert found is None or beam_search(search, 10**6, found.cost) is None
