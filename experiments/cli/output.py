"""Fronts and plans as tables and as JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from decimal import Decimal
from itertools import groupby
from typing import Any

from rich.console import Console, Group
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from prefplan.exact_costs import Number
from prefplan.front import Front, Plan, Purchase, Reason, Stats, UnfinishedError
from prefplan.problem import Problem
from prefplan.scenario.decode import Scenario


def number(value: Number) -> str:
    """Return a cost as a short decimal that reads back as the same number."""
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < 2**53 else repr(value)
    return str(value) if abs(int(value)) < 10**21 else f"{Decimal(int(value)).normalize():g}"


def condense(actions: Sequence[str]) -> str:
    """Return a plan on one line; n equal actions in a row are written `n x ACTION`, those of one letter `nACTION`."""
    runs = [(action, len(list(run))) for action, run in groupby(actions)]
    if all(len(action) == 1 for action in actions):
        return " ".join(action if n == 1 else f"{n}{action}" for action, n in runs)
    return ", ".join(action if n == 1 else f"{n} x {action}" for action, n in runs)


def listed(words: Sequence[str]) -> str:
    """Return words as `a, b and c`."""
    return "".join(words) if len(words) < 2 else f"{', '.join(words[:-1])} and {words[-1]}"


def worth(plan: Plan, *, penalty: str = "preference penalty") -> str:
    """Return the objectives of a plan in words; `penalty` names the preference if there is only one."""
    if len(plan.costs) > 1 or len(plan.preferences) != len(plan.costs):
        return ", ".join(f"{name} {number(value)}" for name, value in plan.objectives.items())
    return f"cost {number(plan.cost)}, {penalty} {number(plan.preference)}"


def plan_json(plan: Plan) -> dict[str, Any]:
    """Return one point of a front as in the documented JSON."""
    return {
        "cost": plan.cost,
        "preference": plan.preference if plan.preferences or not plan.costs else None,
        "costs": plan.costs,
        "preferences": plan.preferences,
        "task_costs": plan.task_costs,
        "violation_costs": plan.violation_costs,
        "plan": list(plan.actions),
        "relaxations": [_purchase_json(purchase) for purchase in plan.relaxations],
    }


def _purchase_json(purchase: Purchase) -> dict[str, Any]:
    if purchase.rule:
        return {"rule": purchase.task, "step": purchase.step, "cost": purchase.cost}
    what = {"skip": True} if purchase.assume is None else {"assume": purchase.assume}
    return {"task": purchase.task, "step": purchase.step, **what, "cost": purchase.cost}


def stats_json(stats: Stats) -> dict[str, Any]:
    """Return the effort of a search as in the documented JSON."""
    return {
        "states": stats.states,
        "expanded": stats.expanded,
        "generated": stats.generated,
        "build_seconds": round(stats.build_seconds, 6),
        "seconds": round(stats.seconds, 6),
    }


def print_json(value: dict[str, Any]) -> None:
    """Print a JSON object on stdout."""
    print(json.dumps(value, indent=1))


def front_json(scenario: Scenario, front: Front) -> dict[str, Any]:
    """Return a front as the documented JSON object."""
    result = _heading(scenario) | {"complete": front.complete, "within": front.within}
    result["front"] = [plan_json(plan) for plan in front]
    if front.reason:
        result["reason"] = asdict(front.reason)
    if front.ended:
        result |= {"ended": front.ended, "complete_below": front.complete_below}
    return result | {"stats": stats_json(front.stats)}


def one_plan_json(scenario: Scenario, plan: Plan, stats: Stats) -> dict[str, Any]:
    """Return one plan as the documented JSON object."""
    return _heading(scenario) | {"complete": True, "plan": plan_json(plan), "stats": stats_json(stats)}


def no_plan_json(scenario: Scenario, reason: Reason, stats: Stats) -> dict[str, Any]:
    """Return the documented JSON object in place of `one_plan_json` if there is no plan."""
    why = {"complete": True, "front": [], "plan": None, "reason": asdict(reason)}
    return _heading(scenario) | why | {"stats": stats_json(stats)}


def unfinished_json(scenario: Scenario, error: UnfinishedError, stats: Stats) -> dict[str, Any]:
    """Return the documented JSON object of a search for one plan that a limit ended."""
    return _heading(scenario) | {
        "complete": False,
        "plan": error.best and plan_json(error.best),
        "ended": error.ended,
        "complete_below": error.complete_below,
        "within": error.within,
        "stats": stats_json(stats),
    }


def _heading(scenario: Scenario) -> dict[str, Any]:
    return {
        "scenario": scenario.name,
        "tasks": [task.name for task in scenario.tasks],
        **({"rules": [rule.name for rule in scenario.rules]} if scenario.rules else {}),
        "contract": scenario.problem().measure.contract,
        "claimed": scenario.problem().measure.claimed,
        "resolution": scenario.problem().resolution,
    }


def relaxed(plan: Plan) -> list[str]:
    """Return an indented line for every relaxation that a plan uses."""
    lines = []
    for bought in plan.relaxations:
        when = f"after action {bought.step}" if bought.step else "at the start"
        if bought.rule:
            lines.append(f"  the rule {bought.task} is broken {when}, for {number(bought.cost)}")
        elif bought.assume is None:
            lines.append(f"  {bought.task} is skipped, for {number(bought.cost)}")
        else:
            lines.append(f"  {bought.task} assumes {bought.assume} {when}, for {number(bought.cost)}")
    return lines


def assumptions(problem: Problem) -> list[str]:
    """Return a sentence for every assumption under which a front is exact."""
    notes = []
    if problem.resolution is not None:
        notes.append(f"Costs are rounded to multiples of {number(problem.resolution)}; the front is exact for those.")
    for objective in problem.objectives:
        if objective.measure.claimed:
            called = "the preference" if problem.is_bi_objective else objective.name
            claim = f"That {called} is {objective.measure.contract} is a claim of the scenario"
            notes.append(f"{claim}, tested on random costs only.")
    return notes


def show_front(console: Console, scenario: Scenario, front: Front) -> None:
    """Print a front as a table, and the plans below it."""
    problem = scenario.problem()
    what, columns = "cost and preference penalty", ["cost", "penalty"]
    if not problem.is_bi_objective:
        columns = list(problem.objective_names)
        what = listed(columns)
    table = Table(title=f"{escape(scenario.name)}: Pareto front of {what}", title_justify="left")
    table.add_column("#", justify="right")
    for name in columns:
        table.add_column(name, justify="right", style="bold")
    for task in scenario.tasks:
        table.add_column(task.name, justify="right")
    for i, plan in enumerate(front):
        table.add_row(str(i), *map(number, (*plan.objectives.values(), *plan.task_costs.values())))
    console.print(table)
    first = "total cost" if problem.is_bi_objective else f"total {problem.cost_names[0]}"
    console.print(
        f"A task's column is its cost: the {first} until it was satisfied. {front.stats.seconds:.2f} s, "
        f"{front.stats.expanded} labels expanded.",
        style="dim",
    )
    if front.complete and front.within:
        told = f"Every best trade-off has a plan here whose cost and penalty are at most {front.within} % larger."
        console.print(told, style="dim")
    for note in assumptions(scenario.problem()):
        console.print(note, style="dim")
    for i, plan in enumerate(front):
        lines = [Text(f"\nPlan {i} ({len(plan.actions)} actions)"), Text(condense(plan.actions) or "(nothing to do)")]
        console.print(Group(*lines, *map(Text, relaxed(plan))))


def show_plan(console: Console, scenario: Scenario, plan: Plan) -> None:
    """Print one plan with its costs and the cost of each task."""
    several = not scenario.problem().is_bi_objective
    counted = scenario.problem().cost_names[0] if several else "cost"
    console.print(f"{scenario.name}: {worth(plan)}", style="bold")
    skipped = {bought.task for bought in plan.relaxations if bought.assume is None and not bought.rule}
    for name, cost in plan.task_costs.items():
        what = "not satisfied" if name in skipped else f"satisfied at {counted} {number(cost)}"
        console.print(f"  {name} {what}")
    console.print(Text(condense(plan.actions) or "(nothing to do)"))
    for line in relaxed(plan):
        console.print(Text(line))
    for note in assumptions(scenario.problem()):
        console.print(note, style="dim")
