"""A plan is made, and its values are checked, when it is read."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from prefplan import Options, Order, Planner, Problem, Relaxation, Rule, Sum, Task, TransitionSystem, WeightedSum
from prefplan.product.product_automaton import Product, Start
from prefplan.search import driver, reference
from prefplan.search.incumbent import run_search
from prefplan.search.paths import Result, plan_of
from prefplan.search.reference import ReferenceSearch


def problem() -> Problem:
    """Return a street with an errand at each end, a toll that may be assumed away, and a rule that may be broken.

    Longer ways lead round the toll, and round the grass.
    """
    street = [(x, "E", x + 1, 1 + x % 3) for x in range(8)] + [(x + 1, "W", x, 1) for x in range(8)]
    street += [
        (4, "N", "hill", 3),
        ("hill", "E", 8, 9),
        (5, "N", "lane", 1),
        ("lane", "E", 7, 5),
        (7, "S", "park", 2),
        ("park", "W", 5, 2),
    ]
    labels = {0: ["home"], 2: ["toll"], 5: ["toll"], 8: ["work"], 6: ["grass"]}
    system = TransitionSystem.from_transitions(street, start=4, labels=labels, propositions=["free"])
    tasks = [
        Task("rest", "F (home & F toll)"),
        Task("earn", "(!toll | free) U work", relax=(Relaxation("free", "toll", 3),)),
    ]
    prices = WeightedSum({"rest": 1, "earn": 2, "green": 1}, over="violation")
    return Problem(
        system, tasks, Sum([(Order(["earn", "rest"]), 1), (prices, 1)]), rules=[Rule("green", "G !grass", skip=4)]
    )


def searched(kind: str) -> Result:
    product = Product(problem())
    if kind == "reference":
        return ReferenceSearch(product, bounds={}).run()
    options = Options(contraction=kind == "contracted")
    return run_search(product, options, {}, None)


KINDS = ("contracted", "whole", "reference")


@pytest.mark.parametrize("kind", KINDS)
def test_the_values_of_all_paths_are_those_of_their_plans(kind: str) -> None:
    result = searched(kind)
    assert len(result.goals) > 2
    assert [goal.plan.objectives for goal in result.goals] == [plan.objectives for plan in Planner(problem()).front()]
    assert {bought.task for goal in result.goals for bought in goal.plan.relaxations} == {"earn", "green"}


@pytest.mark.parametrize("kind", KINDS)
def test_a_path_that_is_wrong_is_noticed(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    made = list[partial[object]]()

    def recorded(product: Product, start: Start, edges: list[list[int]], automata: np.ndarray) -> object:
        made.append(partial(plan_of, product, start, edges, automata))
        return made[-1]()

    for module in (driver, reference):
        monkeypatch.setattr(module, "plan_of", recorded)
    goals = searched(kind).goals
    assert len([goal.plan for goal in goals]) == len(made) > 2
    for goal, other, own in zip(goals, made[1:], made, strict=False):
        product, start, edges, automata = own.args
        shorter = partial(plan_of, product, start, edges[:-1], automata[:-1])
        *others, last = edges[-1]
        ends = [], [*others, last + 1], [*others, edges[0][0]]  # none, another edge of the state, one of another state
        late = automata.copy()
        late[:-1, 1] = automata[0, 1]  # `earn` is satisfied by the last label, which is that of no work
        paths = [([*edges[:-1], end], automata) for end in ends]
        for make in (other, shorter, *(partial(plan_of, product, start, *path) for path in (*paths, (edges, late)))):
            with pytest.raises(AssertionError, match=r"does not have|is not satisfied|other values"):
                _ = replace(goal, make=make).plan


def test_plans_are_made_when_they_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    made = list[int]()

    def counted(*path: Any) -> object:
        made.append(1)
        return plan_of(*path)

    monkeypatch.setattr(driver, "plan_of", counted)
    front = Planner(problem()).front()
    few = front.over(["preference"])
    assert len(front) > 2 and len(front.points) == len(front) and len(few) == 1 and not made[1:]
    assert few[0] is front[-1] and front[-1] is front[-1] and len(made) <= 2
    assert [tuple(plan.objectives.values()) for plan in front] == list(front.points) and len(made) == len(front)
