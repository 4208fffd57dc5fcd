"""Fronts and plans as tables and as JSON."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.text import Text

import prefplan as pp
from experiments.cli.console import table

if TYPE_CHECKING:
    from prefplan.models.feasibility import Geometry


def plan_json(plan: pp.Plan) -> dict[str, Any]:
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


def _purchase_json(purchase: pp.Purchase) -> dict[str, Any]:
    if purchase.rule:
        return {"rule": purchase.task, "step": purchase.step, "cost": purchase.cost}
    what = {"skip": True} if purchase.assume is None else {"assume": purchase.assume}
    return {"task": purchase.task, "step": purchase.step, **what, "cost": purchase.cost}


def stats_json(stats: pp.Stats) -> dict[str, Any]:
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


def front_json(scenario: pp.Scenario, front: pp.Front) -> dict[str, Any]:
    """Return a front as the documented JSON object."""
    result = _heading(scenario) | {"complete": front.complete}
    result["front"] = [plan_json(plan) for plan in front]
    if front.reason:
        result["reason"] = asdict(front.reason)
    if front.ended:
        result |= {"ended": front.ended, "complete_below": front.complete_below}
    return result | {"stats": stats_json(front.stats)}


def one_plan_json(scenario: pp.Scenario, plan: pp.Plan, stats: pp.Stats) -> dict[str, Any]:
    """Return one plan as the documented JSON object."""
    return _heading(scenario) | {"complete": True, "plan": plan_json(plan), "stats": stats_json(stats)}


def no_plan_json(scenario: pp.Scenario, reason: pp.Reason, stats: pp.Stats) -> dict[str, Any]:
    """Return the documented JSON object in place of `one_plan_json` if there is no plan."""
    why = {"complete": True, "front": [], "plan": None, "reason": asdict(reason)}
    return _heading(scenario) | why | {"stats": stats_json(stats)}


def unfinished_json(scenario: pp.Scenario, error: pp.UnfinishedError, stats: pp.Stats) -> dict[str, Any]:
    """Return the documented JSON object of a search for one plan that a limit ended."""
    return _heading(scenario) | {
        "complete": False,
        "plan": error.best and plan_json(error.best),
        "ended": error.ended,
        "complete_below": error.complete_below,
        "within": error.within,
        "stats": stats_json(stats),
    }


def _heading(scenario: pp.Scenario) -> dict[str, Any]:
    return {
        "scenario": scenario.name,
        "tasks": [task.name for task in scenario.tasks],
        **({"rules": [rule.name for rule in scenario.rules]} if scenario.rules else {}),
        "contract": scenario.problem().measure.contract,
        "claimed": scenario.problem().measure.claimed,
        "resolution": scenario.problem().resolution,
    }


def show_front(console: Console, scenario: pp.Scenario, front: pp.Front, whole: Callable[[int], str]) -> None:
    """Print a front as a table, and the plans below it; `whole` as in `Front.listing`."""
    heads, *rows = front.table
    title, count = f"{scenario.name}: {front.title}", len(heads)
    console.print(table(title, heads, rows, right=range(count), bold=range(1, 1 + len(front.objectives))))
    for note in front.notes:
        console.print(note, style="dim")
    for block in front.listing(whole):
        console.print(Text(f"\n{block}"))


def show_plan(console: Console, scenario: pp.Scenario, plan: pp.Plan, geometry: Geometry | None = None) -> None:
    """Print one plan with its costs and the cost of each task, and what was left out for it."""
    costs, *lines = str(plan).split("\n")
    console.print(f"{scenario.name}: {costs}", style="bold")
    console.print(Text("\n".join(lines)))
    notes = [*scenario.problem().assumptions, geometry.note if geometry else None]
    for note in filter(None, notes):
        console.print(note, style="dim")
