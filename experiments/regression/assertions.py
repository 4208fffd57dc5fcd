"""Assertions on fronts, plans and executions, for regression tests; `prefplan.pytest_plugin` makes them fixtures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING

from experiments.cli.choice import Wanted, choose
from experiments.regression.front_comparison import FrontPoint, compare, side_by_side
from prefplan import Front, Plan, Planner, PrefplanError, Problem, Scenario, load
from prefplan.errors import describe
from prefplan.exact_costs import Number, prints_as
from prefplan.scenario.decode import problem_of
from prefplan.text.forms import fits
from prefplan.text.layout import condense, number

if TYPE_CHECKING:
    from experiments.runs.outcome import Outcome

Given = str | Path | Scenario | Problem
"""A scenario's name or path, a loaded scenario, or a problem made in Python."""


def assert_front(scenario: Given, points: Sequence[FrontPoint], *, max_cost: Number | None = None) -> Front:
    """Assert that a Pareto front has exactly these points, and return it.

    Args:
        scenario: what is planned.
        points: (cost, penalty) of each, or all costs and then all preferences; empty if no plan should exist.
        max_cost: as in `prefplan.pareto_front`.

    Raises:
        AssertionError: the front differs; the message shows both side by side.
        PrefplanError: the scenario cannot be used, or the points are no points.
    """
    __tracebackhide__ = True
    name, problem = _named(scenario)
    if not fits(Sequence[Sequence[float]], points):
        raise PrefplanError(f"points: must be a list such as [(COST, PENALTY), ...], not {describe(points)}")
    front = Planner(problem).front(max_cost=max_cost)
    if not front.complete:
        raise AssertionError(f"{name}: the search was stopped ({front.ended}), so that its front is not known")
    rows = compare(points, front)
    if not all(row.same for row in rows):
        why = f"\n\n{front.reason}" if front.reason else ""
        raise AssertionError(f"{name}: the front is not the expected one\n\n{side_by_side(rows)}{why}")
    return front


def assert_plan(
    scenario: Given,
    actions: Sequence[str] | None = None,
    *,
    plan: str | int = "cost",
    task_costs: Mapping[str, Number] | None = None,
    max_cost: Number | None = None,
) -> Plan:
    """Assert that a plan has exactly these actions or these task costs, or both, and return it.

    Args:
        scenario: what is planned.
        actions: from the first to the last; None if they do not matter.
        plan: `cost`, `preference` or its number on the front.
        task_costs: task costs c_i by name, for some or all tasks; None if they do not matter.
        max_cost: as in `prefplan.pareto_front`.

    Raises:
        AssertionError: the plan differs; the message shows the first action that differs, or all task costs.
        PrefplanError: the scenario cannot be used or has no such plan, or nothing is asserted.
    """
    __tracebackhide__ = True
    if actions is None and not task_costs:
        raise PrefplanError("assert_plan: says neither which actions nor which task_costs are right")
    if isinstance(actions, str):
        raise PrefplanError(f"actions: must be a list, such as [{actions!r}], not text")
    name, problem = _named(scenario)
    found = choose(Planner(problem), Wanted(plan, max_cost=max_cost))
    if actions is not None and tuple(actions) != found.actions:
        raise AssertionError(f"{name}: plan {plan!r} is not the expected one\n\n{_parting(actions, found.actions)}")
    for task, cost in (task_costs or {}).items():
        if task not in found.task_costs:
            raise PrefplanError(f"task_costs: {name} has no task {task!r}, only {', '.join(found.task_costs)}")
        if not prints_as(cost, found.task_costs[task]):
            all_costs = ", ".join(f"{task} {number(cost)}" for task, cost in found.task_costs.items())
            raise AssertionError(
                f"{name}: plan {plan!r} satisfies {task} at cost {number(found.task_costs[task])}, "
                f"not {number(cost)} (all: {all_costs})"
            )
    return found


def assert_completed(scenario: str | Path | Scenario, *, plan: str | int = "cost", seed: int | None = None) -> Outcome:
    """Assert that the simulated arm carries a plan out and that its log confirms this, and return the outcome.

    As in `prefplan run`, plans need only what the arm can do, and after a mismatch the arm plans again; `run.replans`
    counts the new plans.

    Args:
        scenario: with a manipulation model.
        plan: `cost`, `preference` or its number on the front.
        seed: None for nominal poses; otherwise objects start up to 5 mm and 5 degrees off.

    Raises:
        AssertionError: the run was not completed; the message says why, and which command shows it.
        PrefplanError: the scenario cannot be used, or has no such plan.
    """
    __tracebackhide__ = True
    # MuJoCo takes a second to load, and tests of fronts do not need it.
    from experiments.runs.certificates import in_a_line
    from experiments.runs.evidence import evidence
    from experiments.runs.geometry import asking_in
    from experiments.runs.run_plan import run_plan, scene_of
    from sim.evidence.certificate import certify

    if isinstance(scenario, Problem):
        raise PrefplanError("assert_completed: needs a scenario, which has the arm's scene; a Problem has none")
    loaded = scenario if isinstance(scenario, Scenario) else load(str(scenario))
    scene = scene_of(loaded)
    given = asking_in(loaded, scene)
    wanted = choose(Planner(given.problem()), Wanted(plan))
    outcome = run_plan(given, scene, wanted, seed=seed, choice=plan)
    certificate = certify(evidence(outcome), scenario=given)
    if not (outcome.run.completed and certificate.confirmed):
        why = in_a_line(certificate) if outcome.run.completed else f"stopped {outcome.run.reason}"
        drawn = "" if seed is None else f" --seed {seed}"
        raise AssertionError(
            f"{given.name}: plan {plan!r} was not carried out: {why}\n\n"
            f"carried out: {condense(outcome.executed)}\n"
            f"to watch it: prefplan run {loaded.path if loaded is scenario else scenario} --plan {plan}{drawn}"
        )
    return outcome


def _named(scenario: Given) -> tuple[str, Problem]:
    found = load(str(scenario)) if isinstance(scenario, str | Path) else scenario
    return found.name if isinstance(found, Scenario) else "problem", problem_of(found)


def _parting(expected: Sequence[str], found: Sequence[str]) -> str:
    """Return text with two plans and the first action in which they differ."""
    pairs = zip_longest(expected, found, fillvalue="(the end)")
    k, one, other = next((k, one, other) for k, (one, other) in enumerate(pairs) if one != other)
    return (
        f"expected: {condense(expected) or 'no action'}\n"
        f"found:    {condense(found) or 'no action'}\n"
        f"action {k} is {other!r}, not {one!r}"
    )
