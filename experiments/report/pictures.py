"""The pictures of a page that are drawn beforehand: automata, and plans on maps and graphs."""

from __future__ import annotations

from html import escape
from typing import Any

from experiments.figures import grid_map
from experiments.figures.diagrams import automaton, route
from experiments.figures.diagrams.route import Route
from experiments.figures.diagrams.system import SystemSizeError
from prefplan.front import Front, Plan
from prefplan.logic.dfa import Automaton
from prefplan.models.graph import GraphModel
from prefplan.models.grid import GridModel
from prefplan.problem import Problem
from prefplan.scenario.decode import Scenario


def automata(problem: Problem) -> dict[str, str]:
    """Return the automaton of every task as HTML."""
    return {task.name: _automaton(one) for task, one in zip(problem.tasks, problem.automata, strict=True)}


def plans(scenario: Scenario, front: Front) -> dict[int, str]:
    """Return the plans that can be drawn, as HTML, by their number on the front."""
    model = scenario.model
    if isinstance(model, GridModel):
        return {i: grid_map.svg(model, plan) for i, plan in enumerate(front)}
    routes = {i: _route(scenario, plan) for i, plan in enumerate(front)}
    return {i: route.svg(found, title=_words(found)) for i, found in routes.items() if found is not None}


def graph_data(scenario: Scenario, plan: Plan) -> dict[str, Any] | None:
    """Return what the page has to know of a plan's picture on a graph; None if there is none."""
    found = _route(scenario, plan)
    if found is None:
        return None
    return {"at": list(found.at), "note": found.note, "words": _words(found)}


def _automaton(found: Automaton) -> str:
    """Return an automaton's picture, or a sentence where it has too many states for one."""
    try:
        return automaton.svg(found)
    except automaton.AutomatonSizeError as error:
        return f'<p class="small">No picture: {escape(str(error))}.</p>'


def _route(scenario: Scenario, plan: Plan) -> Route | None:
    if not isinstance(scenario.model, GraphModel):
        return None
    try:
        return route.route(scenario.problem().system, plan)
    except SystemSizeError:
        return None


def _words(found: Route) -> str:
    stops = [found.nodes[i].text[0] for i in dict.fromkeys(found.at)]
    visited = ", ".join(stops)
    return f"Graph of {len(found.nodes)} states with the plan on it; it visits {visited}"
