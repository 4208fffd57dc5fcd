"""A search that is stopped early returns the exact points below the cost that it reached, and never crashes."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from judge.planners import ListedPlanner

from prefplan import (
    Front,
    GridModel,
    Ledger,
    Location,
    ManipulationModel,
    ModelError,
    Object,
    Options,
    Order,
    Plan,
    Planner,
    Problem,
    Task,
    TransitionSystem,
    UnfinishedError,
    cheapest_plan,
    limits,
    pareto_front,
    preferred_plan,
)
from prefplan.errors import LimitError, PrefplanError
from prefplan.limits import MEMORY_SHARE, Limits, run_within_limits
from prefplan.product.contraction import contract
from prefplan.product.product_automaton import Product
from prefplan.search import incumbent
from prefplan.search.driver import LabelSearch
from prefplan.search.labels import AT, END
from prefplan.search.paths import Result


def errands(number: int) -> Problem:
    """Return errands of three cells each on a 10 x 10 grid."""
    rng = random.Random(number)
    cells = [[(rng.randrange(10), rng.randrange(10)) for _ in range(3)] for _ in range(number)]
    regions = {f"x{x}y{y}": [(x, y, x, y)] for errand in cells for x, y in errand}
    names = [[f"x{x}y{y}" for x, y in errand] for errand in cells]
    tasks = [Task(f"t{i}", f"F({a} & F({b} & F {c}))") for i, (a, b, c) in enumerate(names)]
    return Problem(GridModel((10, 10), (0, 0), regions=regions).transition_system(), tasks, Order())


@pytest.fixture(scope="module")
def problem() -> Problem:
    return errands(6)


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


@pytest.mark.parametrize("megabytes", [0, 0.2, 0.5, 0.8])
def test_little_memory_leaves_a_beginning(problem: Problem, whole: Front, megabytes: float) -> None:
    raw = Options(heuristic=1, preference_bound=False, contraction=False)
    front = pareto_front(problem, max_memory=megabytes * 2**20, options=raw)
    assert front.ended == "memory"
    assert is_a_true_beginning(front, whole)


POPS = 20
"""Labels popped at once, so few that a search of `problem` is interrupted between two plans."""


@pytest.mark.parametrize("slices", [1, 2, 4, 7])
def test_ctrl_c_leaves_a_beginning(
    problem: Problem, whole: Front, slices: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    run, calls = LabelSearch._run, []

    def interrupted(self: LabelSearch, pops: int) -> int:
        calls.append(None)
        if len(calls) > slices:
            raise KeyboardInterrupt
        return run(self, pops)

    monkeypatch.setattr(LabelSearch, "_run", interrupted)
    monkeypatch.setattr(LabelSearch, "pops", POPS)
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
    first, last, run, reached = whole[0], whole[-1], LabelSearch._run, [0]

    def noted(self: LabelSearch, pops: int) -> int:
        end = run(self, pops)
        reached.append(int(self.memory.counters[AT.LOWEST]) >> self.product.graph.shift)
        return end

    monkeypatch.setattr(LabelSearch, "_run", noted)
    monkeypatch.setattr(LabelSearch, "pops", POPS)
    monkeypatch.setattr(Limits, "out_of_time", property(lambda self: reached[-1] > first.cost))
    with pytest.raises(UnfinishedError, match="time limit: a better plan may exist") as caught:
        preferred_plan(problem, max_seconds=600)
    best = caught.value.best
    assert best is not None and (best.cost, best.preference) == (first.cost, first.preference)
    reached.clear()
    reached.append(0)
    with pytest.raises(UnfinishedError, match="no plan is known yet") as caught:
        preferred_plan(problem, max_preference=last.preference, max_seconds=600)
    assert caught.value.best is None


@pytest.mark.parametrize("plan", [pareto_front, cheapest_plan, preferred_plan])
def test_a_limit_that_does_not_exist_is_refused(plan: Callable[..., object]) -> None:
    system = TransitionSystem.from_transitions([("a", "go", "b", 1)], start="a", labels={"b": ["there"]})
    with pytest.raises(PrefplanError, match=r"did you mean .max_cost"):
        plan(Problem(system, [Task("t", "F there")], Order()), max_csot=3)


@pytest.mark.parametrize("is_found_in_time", [False, True])
def test_a_cheapest_plan_that_may_not_be_the_best_of_its_cost_is_not_given_as_the_best(
    problem: Problem, whole: Front, is_found_in_time: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The search finds a cheapest plan first, and then the one of least mu among those."""
    run, ends = LabelSearch._run, list[int]()

    def noted(self: LabelSearch, pops: int) -> int:
        ends.append(run(self, min(pops, 1)))
        return ends[-1]

    monkeypatch.setattr(LabelSearch, "_run", noted)
    monkeypatch.setattr(Limits, "out_of_time", property(lambda self: not is_found_in_time or END.GOALS in ends))
    with pytest.raises(UnfinishedError) as caught:
        cheapest_plan(problem, max_seconds=600)
    best = caught.value.best
    if not is_found_in_time:
        assert best is None and "no plan is known yet" in str(caught.value)
    else:
        assert best is not None and (best.cost, caught.value.within) == (whole[0].cost, 0)
        assert "a better plan may exist; this one costs at most 0.0 % more than the cheapest" in str(caught.value)


@pytest.mark.parametrize(("tasks", "ended"), [(9, "time"), (20, "time"), (9, "interrupt")])
def test_some_plan_is_known_early_and_how_far_it_may_be_from_the_best(
    tasks: int, ended: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Stopped after three turns of the exact search, with the plans that weighted A* has found between them."""
    problem = errands(tasks)
    exact = cheapest_plan(problem).cost if tasks == 9 else None
    run, turns, slow = LabelSearch.run, [], Options(heuristic=1, landmarks=False)

    def stopped(self: LabelSearch, *, most_expanded: float = math.inf) -> Result:
        if not self.prepared.bounds.tables.add_up:
            turns.append(None)
            if len(turns) == 4:
                raise LimitError("time") if ended == "time" else KeyboardInterrupt
        return run(self, most_expanded=most_expanded)

    monkeypatch.setattr(LabelSearch, "run", stopped)
    monkeypatch.setattr(incumbent, "FIRST_EXPANDED", 8000 if tasks == 9 else 20_000)
    with pytest.raises(UnfinishedError, match="this one costs at most .* % more than the cheapest") as caught:
        Planner(problem, options=slow if tasks == 9 else None).cheapest(keep_on_interrupt=True)
    best, within = caught.value.best, caught.value.within
    assert best is not None and within is not None and within < 60
    assert ("interrupted: " in str(caught.value)) == (caught.value.ended == "interrupt") == (ended == "interrupt")
    final = Ledger.of_plan(problem, best).final
    assert final.satisfied == frozenset(problem.names)
    assert (final.cost, final.preference) == (best.cost, best.preference)
    if exact is not None:
        assert exact <= best.cost <= exact * (1 + within / 100)


def test_ctrl_c_is_raised_where_nobody_asked_for_what_is_known(
    problem: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(self: LabelSearch, pops: int) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(LabelSearch, "_run", interrupted)
    for choose in (Planner(problem).cheapest, Planner(problem).preferred):
        with pytest.raises(KeyboardInterrupt):
            choose()
        with pytest.raises(UnfinishedError, match="interrupted: no plan is known yet"):
            choose(keep_on_interrupt=True)


def test_a_model_that_its_bounds_would_not_fit_is_not_begun() -> None:
    grid = GridModel((300, 300), (0, 0), regions={"a": [(299, 299, 299, 299)]})
    front = pareto_front(Problem(grid.transition_system(), [Task("t", "F a")], Order()), max_memory=2**20)
    assert front.ended == "memory" and not front


@pytest.mark.parametrize(("limit", "ended"), [({"max_memory": 5 * 2**20}, "memory"), ({"max_seconds": 0.2}, "time")])
def test_limits_hold_while_a_model_is_built(limit: dict[str, float], ended: str) -> None:
    """Tasks that see every object everywhere leave nothing out of a model of 10^9 states."""
    spots = tuple(Location(f"s{k}", at=(0.1 * k, 0.0)) for k in range(9))
    costs = {"transit": 3, "grasp": 1, "transport": 5, "release": 1}
    model = ManipulationModel("home", costs, spots, tuple(Object(f"o{k}", f"s{k}") for k in range(8)))
    tasks = [Task(f"t{k}", " | ".join(f"F (o{k}_s{x} & X o{k}_s8)" for x in range(9))) for k in range(8)]
    problem = Problem(model.transition_system(), tasks, Order())
    front = ListedPlanner(problem).front(**limit)  # type: ignore[arg-type]
    assert (front.ended, front.plans, front.complete_below) == (ended, (), 0)
    with pytest.raises(UnfinishedError, match=f"stopped by the {ended} limit"):
        ListedPlanner(problem).cheapest(**limit)  # type: ignore[arg-type]


def test_a_kernel_is_stopped_by_the_limits() -> None:
    returned = []

    def run(stop: np.ndarray) -> None:
        while not stop[0]:
            pass
        returned.append(True)

    with Limits(seconds=0), pytest.raises(LimitError, match="stopped by the time limit"):
        run_within_limits(run)
    assert returned == [True]


def test_a_large_graph_is_contracted_within_the_limits() -> None:
    regions = {"a": [(39, 39, 39, 39)], "b": [(0, 39, 0, 39)]}
    grid = GridModel((40, 40), (0, 0), regions=regions).transition_system()
    product = Product(Problem(grid, {"both": "F a & F b"}, Order()))
    assert contract(product) is not None
    with Limits(seconds=0), pytest.raises(LimitError, match="stopped by the time limit"):
        contract(product)


def test_a_grid_larger_than_any_memory_is_refused() -> None:
    with pytest.raises(ModelError, match="10000000 x 10000000 cells need more memory than is free"):
        GridModel((10**7, 10**7), (0, 0)).transition_system()


def test_sixteen_tasks_are_taken() -> None:
    names = [f"p{i}" for i in range(16)]
    edges = [(f"s{i}", "go", f"s{i + 1}", 1) for i in range(16)]
    system = TransitionSystem.from_transitions(
        edges, start="s0", labels={f"s{i + 1}": [name] for i, name in enumerate(names)}
    )
    front = pareto_front(Problem(system, [Task(n, f"F {n}") for n in names], Order()))
    assert points(front) == [(16, 0)]


def test_limits_inside_others_end_with_them() -> None:
    with Limits(seconds=0.0, bytes=1000.0):
        inner = Limits(seconds=60.0)
        assert inner.out_of_time and inner.bytes <= 1000.0
        with inner, pytest.raises(LimitError):
            Limits().check()
    assert Limits(seconds=60.0).seconds_left > 50
    with Limits(seconds=60.0, bytes=1000.0):
        inner = Limits(seconds=0.0, bytes=10.0)
        assert inner.out_of_time and inner.bytes <= 10.0


@pytest.mark.parametrize(
    ("told", "free"),
    [("MemTotal: 900 kB\nMemFree:  100 kB\nMemAvailable:     700 kB\n", 700 * 1024), ("MemFree: 100 kB\n", 2**31)],
)
def test_memory_that_holds_cached_files_is_free(
    told: str, free: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "meminfo").write_text(told)
    monkeypatch.setattr(limits, "MEMORY_INFO", tmp_path / "meminfo")
    assert limits.available_memory() == free
    assert Limits().bytes == pytest.approx(MEMORY_SHARE * free)


def test_without_limits_the_free_memory_is_read_only_if_some_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[int] = []
    monkeypatch.setattr(limits, "available_memory", lambda: read.append(1) or 1000)
    limits.check_limits()
    assert read == []
    with pytest.raises(LimitError, match="memory"):
        limits.check_limits(more_bytes=2000)
