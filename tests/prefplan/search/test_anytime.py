"""Whatever is claimed of a plan or front when the search is stopped is true, at any time; judged by exact fronts."""

from __future__ import annotations

from typing import Any

import judge
import pytest
from judge.verdict import misjudged
from small_models import COSTS, spot

from prefplan import ManipulationModel, Options, Order, Planner, Problem, UnfinishedError, pareto_front
from prefplan.heuristics.prepare import Prepared
from prefplan.limits import Limits
from prefplan.models.manipulation.model import Object
from prefplan.scenario.decode import from_dict
from prefplan.search import incumbent
from prefplan.search.driver import LabelSearch

SLOW = Options(heuristic=0)
"""Without heuristics, the exact search takes longer than weighted A* for its first plan."""


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another plan is looked for after a few labels, and limits are checked after every label."""
    monkeypatch.setattr(incumbent, "FIRST_EXPANDED", 5)
    monkeypatch.setattr(LabelSearch, "pops", 1)


def stop_after(slices: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the time be up when searches have popped so many labels."""
    run, ran = LabelSearch._run, list[int]()

    def counted(search: LabelSearch, pops: int) -> int:
        ran.append(pops)
        return run(search, pops)

    monkeypatch.setattr(LabelSearch, "_run", counted)
    monkeypatch.setattr(Limits, "out_of_time", property(lambda limits: len(ran) > slices))


def problems() -> list[Any]:
    return [judge.random_errands(seed, "order") for seed in range(3)] + [
        judge.random_problem(seed, kind="order", tasks=3, relaxed=False) for seed in range(6)
    ]


def test_a_search_with_some_plan_finds_what_the_exact_one_finds() -> None:
    for problem in problems():
        planned = from_dict(problem.scenario(), name="problem").problem()
        front = pareto_front(planned, max_cost=100)
        if front:
            plan = Planner(planned).cheapest()
            assert (plan.cost, plan.preference) == (front[0].cost, front[0].preference)
            assert misjudged(problem, plan) is None


@pytest.mark.parametrize("single", [False, True])
def test_weighted_search_of_generated_states_has_the_bounds_of_their_projections(
    single: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    places = (spot("s0"), spot("s1"), spot("s2"), spot("bin", capacity=2))
    objects = tuple(Object(f"o{k}", f"s{k}") for k in range(3))
    model = ManipulationModel("home", COSTS, places, objects, listed_states=0)
    problem = Problem(model.transition_system(), {"a": "F o0_bin", "b": "F (o1_bin & F o2_s0)"}, Order())
    looked: list[float] = []
    guided = Prepared.guided

    def counted(prepared: Prepared, weight: float) -> Prepared:
        made = guided(prepared, weight)
        # Without them, a state itself is looked up in the tables, beyond their end.
        assert made.bounds.tables.projections is prepared.bounds.tables.projections is not None
        looked.append(weight)
        return made

    monkeypatch.setattr(Prepared, "guided", counted)
    planner = Planner(problem)
    found = [planner.cheapest()] if single else planner.front()
    monkeypatch.setattr(incumbent, "FIRST_EXPANDED", 100_000)
    exact = Planner(problem).front()
    assert looked
    assert [plan.objectives for plan in found] == [plan.objectives for plan in (exact[:1] if single else exact)]


def test_a_stopped_search_for_a_plan_proves_no_more_than_is_so() -> None:
    known = 0
    for problem in problems():
        planned = from_dict(problem.scenario(), name="problem").problem()
        front = pareto_front(planned, max_cost=100)
        for slices in (0, 3, 9, 20, 60) if front else ():
            with pytest.MonkeyPatch.context() as patch:
                stop_after(slices, patch)
                try:
                    plan, within = Planner(planned, options=SLOW).cheapest(max_seconds=60), 0
                except UnfinishedError as error:
                    assert (error.complete_below or 0) <= front[0].cost
                    plan, within = error.best, error.within
            if plan is not None:
                known += 1
                assert misjudged(problem, plan) is None
                if within is not None:
                    assert front[0].cost <= plan.cost <= front[0].cost * (1 + within / 100) * (1 + 1e-12)
    assert known > 10


def test_a_stopped_front_has_every_point_below_a_cost_or_some_plan() -> None:
    others = beginnings = 0
    for problem in (*problems(), judge.random_errands(0, "max")):
        planned = from_dict(problem.scenario(), name="problem").problem()
        exact = [(plan.cost, plan.preference) for plan in pareto_front(planned, max_cost=100)]
        for slices in (5, 10, 20, 40, 80) if exact else ():
            with pytest.MonkeyPatch.context() as patch:
                stop_after(slices, patch)
                front = pareto_front(planned, options=SLOW, max_cost=100)
            assert all(misjudged(problem, plan) is None for plan in front)
            points = [(plan.cost, plan.preference) for plan in front]
            below = front.complete_below or 0
            assert front.complete or all(point in points for point in exact if point[0] < below)
            beginning = points == exact[: len(points)]
            assert beginning or (len(points) == 1 and points[0][0] >= exact[0][0])
            others += bool(points) and not beginning
            beginnings += front.ended is not None and beginning and bool(points)
    assert others > 2 and beginnings > 2
