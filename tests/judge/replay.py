"""Evaluate a plan by its trace alone, independently of how it was found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from judge.preferences import Mu, Number, exact
from judge.problems import GraphProblem, JudgedTask
from judge.semantics import holds_now, satisfaction_index


class Replay(NamedTuple):
    """The costs and mu of a plan; `satisfied`, `task_costs` and `violations` are in the order of the tasks.

    `ends` says whether the last action, and none before it, leaves every task satisfied or skipped.
    """

    cost: Number
    task_costs: tuple[Number, ...]
    mu: Number
    satisfied: tuple[bool, ...]
    violations: tuple[Number, ...]
    states: tuple[str, ...]
    ends: bool


def replay(
    problem: GraphProblem,
    actions: Sequence[str],
    relaxations: Sequence[Mapping[str, Any]] = (),
    *,
    mu: Mu | None = None,
) -> Replay:
    """Replay a plan on the graph and evaluate its trace (Definition 3, equations (1) and (2)).

    Args:
        problem: the problem.
        actions: the plan.
        relaxations: as the command line reports them: `task`, `step`, `cost`, and `assume` or `skip`.
        mu: preference function of (task costs, violation costs); the problem's own when None.

    Raises:
        ValueError: an action or a relaxation that the problem does not offer.
    """
    states = [problem.start]
    spent: list[Number] = [0]
    for step, action in enumerate(actions):
        offered = {edge.action: edge for edge in problem.outgoing.get(states[-1], [])}
        if action not in offered:
            raise ValueError(f"step {step}: no action {action!r} in {states[-1]!r}, only {sorted(offered)}")
        states.append(offered[action].target)
        spent.append(spent[-1] + offered[action].cost)
    if unknown := {entry["task"] for entry in relaxations} - set(problem.names):
        raise ValueError(f"relaxations of unknown tasks {sorted(unknown)}")
    verdicts = [
        _judge(problem, task, states, [entry for entry in relaxations if entry["task"] == task.name])
        for task in problem.tasks
    ]
    task_costs = tuple(spent[-1] if verdict.end is None else spent[verdict.end] for verdict in verdicts)
    violations = tuple(verdict.paid for verdict in verdicts)
    value = mu or problem.mu()
    required = [verdict.end for verdict in verdicts if not verdict.skipped]
    return Replay(
        spent[-1],
        task_costs,
        value(task_costs, violations),
        tuple(verdict.end is not None for verdict in verdicts),
        violations,
        tuple(states),
        None not in required and max((k for k in required if k is not None), default=0) == len(actions),
    )


class _Verdict(NamedTuple):
    end: int | None
    paid: Number
    skipped: bool


def _judge(
    problem: GraphProblem, task: JudgedTask, states: Sequence[str], relaxations: Sequence[Mapping[str, Any]]
) -> _Verdict:
    """Say when a task is satisfied on the trace as relaxed, and what was paid."""
    prices = [exact(entry["cost"]) for entry in relaxations]
    if any(entry.get("skip") for entry in relaxations):
        if len(relaxations) != 1 or relaxations[0]["step"] != 0 or prices[0] != task.skip:
            raise ValueError(f"{task.name} cannot be skipped like this: {relaxations}")
        return _Verdict(None, prices[0], True)
    trace = [problem.label(state) for state in states]
    for entry, price in zip(relaxations, prices, strict=True):
        step, assume = entry["step"], entry["assume"]
        label = problem.label(states[step])
        allowed = (r for r in task.relax if r.assume == assume and holds_now(r.when, label) and r.cost == price)
        if assume in trace[step] or not any(allowed):
            raise ValueError(f"{task.name} may not assume {assume!r} at step {step} for {price}")
        trace[step] = trace[step] | {assume}
    index = satisfaction_index(task.formula, trace)
    late = [entry["step"] for entry in relaxations if index is not None and entry["step"] > index]
    if late:
        raise ValueError(f"{task.name} is satisfied at step {index}, yet relaxed at {late}")
    return _Verdict(index, sum(prices), False)
