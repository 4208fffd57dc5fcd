"""The judge of relaxed and skipped tasks against hand-computed cases."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from judge import Edge, GraphProblem, JudgedTask, Relaxation, exact_front, parse, replay


def relaxed(formula: str, *entries: tuple[str, str, int], skip: int | None = None) -> JudgedTask:
    return JudgedTask("phi1", parse(formula), tuple(Relaxation(p, parse(b), w) for p, b, w in entries), skip)


def line(task: JudgedTask, *marked: str) -> GraphProblem:
    """Return a line of states with edges of cost 1; a second task requires its end."""
    last = f"s{len(marked) - 1}"
    edges = tuple(Edge(f"s{k}", "go", 1, f"s{k + 1}") for k in range(len(marked) - 1))
    states = {f"s{k}": frozenset(word) | ({"end"} if f"s{k}" == last else set()) for k, word in enumerate(marked)}
    weights = {"phi1": 1, "phi2": 1}
    return GraphProblem(
        "s0",
        edges,
        states,
        (task, JudgedTask("phi2", parse("F end"))),
        {"kind": "weighted-sum", "weights": weights, "over": "violation"},
    )


@pytest.mark.parametrize(
    ("task", "marked", "front"),
    [
        (relaxed("F a", ("a", "b", 5)), ("", "b", ""), [(2, 5)]),
        (relaxed("F a", ("a", "b", 5)), ("b", ""), [(1, 5)]),
        (relaxed("F a", ("a", "b", 5)), ("b", "a"), [(1, 0)]),
        (relaxed("F a", ("a", "b", 5), skip=4), ("b", ""), [(1, 4)]),
        (relaxed("F a", skip=4), ("", "a"), [(1, 0)]),
        (relaxed("F(a & b)", ("a", "c", 2), ("b", "c", 3)), ("c", ""), [(1, 5)]),
        (relaxed("F(a & b)", ("a", "true", 2), ("b", "c", 3)), ("", "b", ""), [(2, 2)]),
        (relaxed("F(a & X a)", ("a", "true", 2)), ("", "", ""), [(2, 4)]),
        (relaxed("a U end", ("a", "true", 2)), ("", "a", "", ""), [(3, 4)]),
        (relaxed("F a"), ("b", ""), []),
    ],
)
def test_relaxations_are_paid_each_time_and_may_join(
    task: JudgedTask, marked: tuple[str, ...], front: list[tuple[int, int]]
) -> None:
    assert exact_front(line(task, *marked), max_cost=10) == front


def test_a_skipped_task_costs_the_whole_plan() -> None:
    problem = line(relaxed("F a", skip=4), "", "a", "", "")
    outcome = replay(problem, ["go"] * 3, [{"task": "phi1", "step": 0, "skip": True, "cost": 4}])
    assert outcome.task_costs == (3, 3)
    assert outcome.violations == (4, 0)
    assert outcome.satisfied == (False, True)
    assert outcome.ends


def test_skipping_every_task_needs_no_action() -> None:
    problem = line(relaxed("F a", skip=4), "", "")
    problem = replace(problem, tasks=(problem.tasks[0], replace(problem.tasks[1], skip=3)))
    assert exact_front(problem, max_cost=10) == [(0, 7), (1, 4)]


@pytest.mark.parametrize(
    "entry",
    [
        {"task": "phi1", "step": 0, "assume": "a", "cost": 5},
        {"task": "phi1", "step": 1, "assume": "a", "cost": 4},
        {"task": "phi1", "step": 0, "skip": True, "cost": 5},
        {"task": "phi3", "step": 1, "assume": "a", "cost": 5},
    ],
    ids=["when does not hold", "wrong price", "may not be skipped", "no such task"],
)
def test_relaxations_that_are_not_offered_are_refused(entry: dict[str, Any]) -> None:
    problem = line(relaxed("F a", ("a", "b", 5)), "", "b", "")
    with pytest.raises(ValueError):
        replay(problem, ["go", "go"], [entry])
