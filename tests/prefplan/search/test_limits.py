"""A search that is stopped early gives the exact points below the cost that it got to, and never crashes."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from prefplan import (
    Front,
    GridModel,
    ModelError,
    Options,
    Order,
    Plan,
    Planner,
    Problem,
    Task,
    TransitionSystem,
    UnfinishedError,
    cheapest_plan,
    pareto_front,
    preferred_plan,
)
from prefplan.errors import PrefplanError
from prefplan.limits import Limits
from prefplan.search.driver import BiObjectiveSearch


@pytest.fixture(scope="module")
def problem() -> Problem:
    """Six errands of three cells each on a 10 x 10 grid."""
    rng = random.Random(6)
    cells = [[(rng.randrange(10), rng.randrange(10)) for _ in range(3)] for _ in range(6)]
    regions = {f"x{x}y{y}": [(x, y, x, y)] for errand in cells for x, y in errand}
    grid = GridModel((10, 10), (0, 0), regions=regions)
    tasks = []
    for i, errand in enumerate(cells):
        a, b, c = (f"x{x}y{y}" for x, y in errand)
        tasks.append(Task(f"t{i}", f"F({a} & F({b}) & F({c}))"))
    return Problem(grid.transition_system(), tasks, Order())


@pytest.fixture(scope="module")
def whole(problem: Problem) -> Front:
    return pareto_front(problem)


def points(front: Front) -> list[tuple[object, object]]:
    return [worth(plan) for plan in front]


def worth(plan: Plan) -> tuple[object, object]:
    return plan.cost, plan.preference


def is_a_true_beginning(front: Front, whole: Front) -> bool:
    below = 0 if front.complete_below is None else front.complete_below
    known = points(front) == points(whole)[: len(front)]
    return known and all(point in points(front) for point in points(whole) if point[0] < below)  # type: ignore[operator]


def test_no_time_leaves_a_beginning(problem: Problem, whole: Front) -> None:
    front = pareto_front(problem, max_seconds=0)
    assert front.ended == "time" and not front.complete and front.reason is None
    assert is_a_true_beginning(front, whole)


@pytest.mark.parametrize("megabytes", [0, 0.2, 0.5, 0.8])
def test_little_memory_leaves_a_beginning(problem: Problem, whole: Front, megabytes: float) -> None:
    raw = Options(heuristic=1, preference_bound=False, contraction=False)
    front = pareto_front(problem, max_memory=megabytes * 2**20, options=raw)
    assert front.ended == "memory"
    assert is_a_true_beginning(front, whole)


@pytest.mark.parametrize("slices", [1, 2, 4, 7])
def test_ctrl_c_leaves_a_beginning(
    problem: Problem, whole: Front, slices: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    run, calls = BiObjectiveSearch._run, []

    def interrupted(self: BiObjectiveSearch, pops: int) -> int:
        calls.append(None)
        if len(calls) > slices:
            raise KeyboardInterrupt
        return run(self, pops)

    monkeypatch.setattr(BiObjectiveSearch, "_run", interrupted)
    front = Planner(problem).front(keep_on_interrupt=True)
    assert front.ended == "interrupt"
    assert is_a_true_beginning(front, whole)
    calls.clear()
    with pytest.raises(KeyboardInterrupt):
        Planner(problem).front()


def test_no_time_leaves_no_single_plan(problem: Problem) -> None:
    for choose in (cheapest_plan, preferred_plan):
        with pytest.raises(UnfinishedError, match="stopped by the time limit: no plan is known yet") as caught:
            choose(problem, max_seconds=0)
        assert (caught.value.ended, caught.value.best) == ("time", None)


def test_a_limit_leaves_the_best_plan_by_then(problem: Problem, whole: Front, monkeypatch: pytest.MonkeyPatch) -> None:
    first, last = whole[0], whole[-1]
    monkeypatch.setattr(Limits, "out_of_time", property(lambda self: self.complete_below > first.cost))
    with pytest.raises(UnfinishedError, match="time limit: a better plan may exist") as caught:
        preferred_plan(problem, max_seconds=600)
    best = caught.value.best
    assert best is not None and (best.cost, best.preference) == (first.cost, first.preference)
    with pytest.raises(UnfinishedError, match="no plan is known yet") as caught:
        preferred_plan(problem, max_preference=last.preference, max_seconds=600)
    assert caught.value.best is None


@pytest.mark.parametrize("plan", [pareto_front, cheapest_plan, preferred_plan])
def test_a_limit_that_does_not_exist_is_refused(plan: Callable[..., object]) -> None:
    system = TransitionSystem.from_transitions([("a", "go", "b", 1)], start="a", labels={"b": ["there"]})
    with pytest.raises(TypeError, match="max_csot"):
        plan(Problem(system, [Task("t", "F there")], Order()), max_csot=3)


@pytest.mark.parametrize("searches_in_time", [0, 1])
def test_a_cheapest_plan_that_may_not_be_the_best_of_its_cost_is_not_given(
    problem: Problem, searches_in_time: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first search finds a cheapest plan, the second the one of least mu among those."""
    run, searches = BiObjectiveSearch._run, set[BiObjectiveSearch]()

    def counted(self: BiObjectiveSearch, pops: int) -> int:
        searches.add(self)
        return run(self, pops)

    monkeypatch.setattr(BiObjectiveSearch, "_run", counted)
    monkeypatch.setattr(Limits, "out_of_time", property(lambda self: len(searches) > searches_in_time))
    with pytest.raises(UnfinishedError, match="no plan is known yet"):
        cheapest_plan(problem, max_seconds=600)


def test_a_model_that_its_bounds_would_not_fit_is_not_begun() -> None:
    grid = GridModel((300, 300), (0, 0), regions={"a": [(299, 299, 299, 299)]})
    front = pareto_front(Problem(grid.transition_system(), [Task("t", "F a")], Order()), max_memory=2**20)
    assert front.ended == "memory" and not front


def test_a_grid_larger_than_any_memory_is_refused() -> None:
    with pytest.raises(ModelError, match="10000000 x 10000000 cells need more memory than is free"):
        GridModel((10**7, 10**7), (0, 0)).transition_system()


def test_sixteen_tasks_are_taken_and_a_hundred_named_too_many() -> None:
    names = [f"p{i}" for i in range(100)]
    edges = [(f"s{i}", "go", f"s{i + 1}", 1) for i in range(100)]
    system = TransitionSystem.from_transitions(
        edges, start="s0", labels={f"s{i + 1}": [name] for i, name in enumerate(names)}
    )
    front = pareto_front(Problem(system, [Task(n, f"F {n}") for n in names[:16]], Order()))
    assert points(front) == [(16, 0)]
    with pytest.raises(PrefplanError, match="100 are more than the 20"):
        Problem(system, [Task(n, f"F {n}") for n in names], Order())
