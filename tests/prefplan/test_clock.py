"""However large the input, the limit of time is looked at soon: counted by a clock that tells work, not time.

A line of the planner that is executed counts as one unit of work, and as one more for every thousand entries of the
arrays in its scope.
"""

from __future__ import annotations

import random
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import pytest
from scenario_texts import task_tables

import prefplan
from prefplan import Expression, GridModel, Order, Planner, Problem, Relaxation, Rule, Sum, Task, WeightedSum
from prefplan.limits import Limits
from prefplan.preferences.objective import NamedPreference
from prefplan.scenario.decode import loads

MOST_WORK = 100_000
"""Most work between two looks at the clock: about a tenth of a second."""

FOLDER = str(Path(prefplan.__file__).parent)


class WorkClock:
    """Counts the work between two looks at the clock."""

    def __init__(self) -> None:
        self.work, self.most, self.where = 0.0, 0.0, ""

    def look(self) -> None:
        self.work = 0.0

    @contextmanager
    def running(self) -> Iterator[None]:
        """Count the work that is done in this context."""
        before = sys.gettrace()
        sys.settrace(self.trace)
        try:
            yield
        finally:
            sys.settrace(before)

    def trace(self, frame: FrameType, event: str, arg: Any) -> Any:
        if not frame.f_code.co_filename.startswith(FOLDER):
            return None
        if event == "line":
            arrays = (value.size for value in frame.f_locals.values() if isinstance(value, np.ndarray))
            self.work += 1 + sum(arrays) / 1000
            if self.work > self.most:
                self.most, self.where = self.work, f"{frame.f_code.co_filename}:{frame.f_lineno}"
        return self.trace


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> WorkClock:
    counted = WorkClock()

    def out_of_time(limits: Limits) -> bool:
        counted.look()
        return False

    monkeypatch.setattr(Limits, "out_of_time", property(out_of_time))
    return counted


def on_grid(size: int, named: int, make: Callable[[list[str]], list[Task]], **more: Any) -> Problem:
    cells = random.Random(named).sample(range(size * size), named)
    names = [f"p{k}" for k in range(named)]
    regions = {name: [divmod(cell, size) * 2] for name, cell in zip(names, cells, strict=True)}
    system = GridModel((size, size), (0, 0), regions=regions).transition_system()
    return Problem(system, make(names), **{"preference": Order(), **more})


def conjunction(number: int) -> Callable[[list[str]], list[Task]]:
    return lambda names: [
        Task("all", " & ".join(f"F {name}" for name in names[:number])),
        Task("other", f"F ({names[-2]} & F {names[-1]})"),
    ]


def errands(names: list[str]) -> list[Task]:
    return [Task(f"t{k}", f"F ({a} & F {b})") for k, (a, b) in enumerate(zip(names[::2], names[1::2], strict=True))]


def bounded(names: list[str]) -> list[Task]:
    a, b, c = names
    return [Task("x", f"F ({a} & F[1,40] {b})"), Task("y", f"F[0,60] ({b} & X F {c})")]


def relaxed(names: list[str]) -> list[Task]:
    offers = [Relaxation(name, when=names[0], cost=k + 1) for k, name in enumerate(names[1:])]
    return [Task(f"t{k}", f"!{names[0]} U {name}", relax=[offers[k]], skip=9) for k, name in enumerate(names[1:])]


def in_a_circle(names: list[str]) -> list[Task]:
    return [Task(f"t{k}", f"!{name} U {names[k - 1]}") for k, name in enumerate(names)]


PRICED = Sum(((Order(), 1), (WeightedSum({"r0": 1, "r1": 2}, over="violation"), 1)))
PAID = WeightedSum({"t0": 1, "t1": 2, "t2": 3}, over="violation")
RULES = [Rule("r0", "!p0 W p3", skip=2), Rule("r1", "G (p1 -> G[1,9] !p2)", skip=1), Rule("r2", "!p4 W p5")]
SEVERAL = [NamedPreference("order", Order()), NamedPreference("product", Expression("t0 * t1"))]

BLOCKS = """
[model]
kind = "manipulation"
start = "home"
costs = { transit = 3, grasp = 1, transport = 5, release = 1 }
[model.locations]
LOCATIONS
[model.objects]
OBJECTS
"""


def blocks(number: int) -> Problem:
    locations = "\n".join(f"s{k} = {{ at = [0.{30 + 5 * k}, 0.0] }}" for k in range(number + 2))
    objects = "\n".join(f'o{k} = {{ start = "s{k}" }}' for k in range(number))
    tasks = task_tables(**{f"t{k}": f"F o{k}_s{k + 1}" for k in range(number)})
    return loads(BLOCKS.replace("LOCATIONS", locations).replace("OBJECTS", objects) + tasks).problem()


def plan_all(make: Callable[[], Problem]) -> None:
    with Limits(), suppress(prefplan.NoPlanError):
        planner = Planner(make())
        planner.front()
        planner.cheapest()


@pytest.mark.parametrize(
    "make",
    [
        pytest.param(lambda: on_grid(10, 10, conjunction(8)), id="an automaton of 256 states"),
        pytest.param(lambda: on_grid(10, 16, errands), id="many tasks"),
        pytest.param(lambda: on_grid(100, 6, errands, preference=WeightedSum({"t0": 2, "t1": 1, "t2": 3})), id="grid"),
        pytest.param(lambda: on_grid(10, 3, bounded), id="bounds"),
        pytest.param(
            lambda: on_grid(6, 4, relaxed, preference=WeightedSum({"t0": 1, "t1": 2, "t2": 3}, over="violation")),
            id="relaxed",
        ),
        pytest.param(lambda: on_grid(8, 6, errands, preference=PRICED, rules=RULES), id="rules"),
        pytest.param(lambda: on_grid(6, 6, in_a_circle), id="conflict"),
        pytest.param(lambda: on_grid(8, 4, errands, preference=SEVERAL), id="several preferences"),
        pytest.param(lambda: on_grid(8, 4, errands, preference=Expression("t0 * t1")), id="expression"),
        pytest.param(lambda: blocks(3), id="blocks"),
        pytest.param(lambda: blocks(6), id="blocks that are not listed"),
    ],
)
def test_the_clock_is_looked_at_before_much_work_is_done(make: Callable[[], Problem], clock: WorkClock) -> None:
    plan_all(make)  # compiles what is needed
    with clock.running():
        plan_all(make)
    assert 0 < clock.most < MOST_WORK, clock.where


def test_a_large_grid_is_built_in_steps(clock: WorkClock) -> None:
    with Limits(), clock.running():
        on_grid(400, 20, errands)
    assert 0 < clock.most < MOST_WORK, clock.where
