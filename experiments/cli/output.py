"""Fronts and plans as tables and as JSON."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rich.console import Console

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


def print_json(value: dict[str, Any]) -> None:
    """Print a JSON object on stdout."""
    print(json.dumps(value, indent=1))


def result_json(scenario: pp.Scenario, planner: pp.Planner, **found: Any) -> dict[str, Any]:
    """Return the documented JSON object of a search: what it found, and the entries that all searches have."""
    problem, stats = scenario.problem(), planner.stats
    return {
        "scenario": scenario.name,
        "tasks": [task.name for task in scenario.tasks],
        **({"rules": [rule.name for rule in scenario.rules]} if scenario.rules else {}),
        "contract": problem.measure.contract,
        "claimed": problem.measure.claimed,
        "resolution": problem.resolution,
        **found,
        "stats": {
            "states": stats.states,
            "expanded": stats.expanded,
            "generated": stats.generated,
            "build_seconds": round(stats.build_seconds, 6),
            "seconds": round(stats.seconds, 6),
        },
        **_geometry_json(scenario, planner),
    }


def _geometry_json(scenario: pp.Scenario, planner: pp.Planner) -> dict[str, Any]:
    """Return what is known of the geometry of plans; empty for a model without an arm."""
    if not isinstance(scenario.model, pp.ManipulationModel):
        return {}
    if scenario.feasible is None or getattr(scenario.feasible, "failed", False):
        return {"geometry": "abstract" if scenario.model.abstract else "not checked"}
    assert (found := planner.geometry) is not None
    places = found.left_out.items()
    left_out = [{"object": obj, "location": place, "reason": reason} for (obj, place), reason in places]
    return {"geometry": "checked", "left_out": left_out, "if_it_could": list(found.abstract) if left_out else []}


def show_front(console: Console, scenario: pp.Scenario, front: pp.Front, whole: Callable[[int], str]) -> None:
    """Print a front as a table, and the plans below it; `whole` as in `Front.listing`."""
    heads, *rows = front.table
    title, count = f"{scenario.name}: {front.title}", len(heads)
    console.print(table(title, heads, rows, right=range(count), bold=range(1, 1 + len(front.objectives))))
    for note in front.notes:
        console.print(note, style="dim")
    for block in front.listing(whole):
        console.print(f"\n{block}")


def show_plan(console: Console, scenario: pp.Scenario, plan: pp.Plan, geometry: Geometry | None = None) -> None:
    """Print one plan with its costs and the cost of each task, and what was left out for it."""
    costs, *lines = str(plan).split("\n")
    console.print(f"{scenario.name}: {costs}", style="bold")
    console.print("\n".join(lines))
    notes = [*scenario.problem().assumptions, geometry.note if geometry else None]
    for note in filter(None, notes):
        console.print(note, style="dim")
