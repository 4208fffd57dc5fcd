"""What a bound of the growth of mu saves on fronts of sums of the tasks' costs."""

from __future__ import annotations

import random

import pytest

from prefplan import (
    Expression,
    GridModel,
    NamedPreference,
    Options,
    Order,
    Planner,
    Preference,
    Problem,
    Task,
    WeightedSum,
)

SUM = WeightedSum({f"t{i}": i % 3 + 1 for i in range(6)})


@pytest.mark.parametrize(
    ("preference", "factor"),
    [
        pytest.param(SUM, 10, id="weighted sum"),
        pytest.param(Expression("max(t0, t1) - min(t0, t1) + t2"), 10, id="spread"),
        # Tables are of three tasks: none is of both of these, so that only what grows with t2 is bounded.
        pytest.param(Expression("max(t0, t5) - min(t0, t5) + t2"), 1, id="spread over several tables"),
        # Orders have no bound.
        pytest.param([NamedPreference("order", Order()), NamedPreference("sum", SUM)], 5, id="two preferences"),
    ],
)
def test_a_bound_of_mu_spares_most_labels(preference: Preference | list[NamedPreference], factor: int) -> None:
    draw, names = random.Random(2), [f"r{i}" for i in range(18)]
    cells = [divmod(cell, 10) for cell in draw.sample(range(100), len(names))]
    model = GridModel((10, 10), (0, 0), regions={name: [cell * 2] for name, cell in zip(names, cells, strict=True)})
    tasks = [Task(f"t{i}", "F({} & F {} & F {})".format(*names[3 * i : 3 * i + 3])) for i in range(6)]
    problem = Problem(model.transition_system(), tasks, preference)
    found, expanded = [], []
    for bounded in (True, False):
        planner = Planner(problem, options=Options(preference_bound=bounded))
        found.append([tuple(plan.objectives.values()) for plan in planner.front()])
        expanded.append(planner.stats.expanded)
    assert found[0] == found[1]
    assert factor * expanded[0] < expanded[1], expanded
