"""The tasks and rules to blame where no plan exists."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import pytest

from prefplan import Order, Problem, Reason, Rule, Task, TransitionSystem, pareto_front
from prefplan.search import infeasibility

ROOMS = "abcdefgh"
ONE_WAY = TransitionSystem.from_transitions(
    [("hall", room, room, 1) for room in ROOMS] + [(x, y, x + y, 1) for x, y in combinations(ROOMS, 2)],
    start="hall",
    labels={room: [room] for room in ROOMS} | {x + y: [y] for x, y in combinations(ROOMS, 2)},
)
"""From the hall to two of the rooms, in order, and no further."""


def visits(rooms: str) -> list[Task]:
    return [Task(room, f"F {room}") for room in rooms]


@pytest.mark.parametrize(
    ("tasks", "kind", "blamed"),
    [
        ([*visits("ab"), Task("both", "F (c & a)")], "task", ["both"]),
        ([*visits("abc"), Task("again", "F (b & F a)")], "task", ["again"]),
        ([*visits("dab"), Task("before", "!b U d")], "conflict", ["b", "before"]),
        ([*visits("cb"), Task("a_last", "F (c & X F h)")], "conflict", ["b", "a_last"]),
        (visits("abcd"), "conflict", ["b", "c", "d"]),
        (visits(ROOMS), "conflict", ["f", "g", "h"]),
    ],
)
def test_any_fewer_of_the_tasks_to_blame_can_be_satisfied(tasks: list[Task], kind: str, blamed: list[str]) -> None:
    reason = pareto_front(Problem(ONE_WAY, tasks, Order())).reason
    assert reason == Reason(kind, tuple(blamed))
    named = [task for task in tasks if task.name in blamed]
    for few in combinations(named, len(named) - 1):
        assert not few or pareto_front(Problem(ONE_WAY, few, Order()))


def test_any_fewer_of_the_rules_to_blame_can_be_kept() -> None:
    rules = [Rule(f"not_{room}", f"G !{room}") for room in ROOMS]
    reason = pareto_front(Problem(ONE_WAY, [Task("some", "F (f | g | h)")], Order(), rules=rules)).reason
    assert reason == Reason("rule", ("not_f", "not_g", "not_h"))


def test_searches_grow_no_faster_than_the_pairs_of_tasks(monkeypatch: pytest.MonkeyPatch) -> None:
    searches = 0

    def counted(*arguments: Any) -> bool:
        nonlocal searches
        searches += 1
        return is_satisfiable(*arguments)

    is_satisfiable = infeasibility._is_satisfiable
    monkeypatch.setattr(infeasibility, "_is_satisfiable", counted)
    first = [("hall", room, f"{room}1", 1) for room in ROOMS]
    later = [(f"{x}{k}", y, f"{y}{k + 1}", 1) for k in range(1, 5) for x in ROOMS for y in ROOMS]
    labels = {f"{room}{k}": [room] for room in ROOMS for k in range(1, 6)}
    five_visits = TransitionSystem.from_transitions(first + later, start="hall", labels=labels)
    reason = pareto_front(Problem(five_visits, visits(ROOMS), Order())).reason
    assert reason is not None and len(reason.tasks) == 6
    assert searches <= 1 + 8 + 28 + 8
