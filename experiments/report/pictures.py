"""The pictures of a page that are drawn in advance: automata, and plans on maps and graphs."""

from html import escape
from pathlib import Path
from typing import Any

from experiments.figures import maps
from experiments.figures.diagrams import automaton, node_link, route
from experiments.figures.diagrams.automaton_text import table_text
from experiments.figures.diagrams.guards import AutomatonSizeError
from experiments.figures.diagrams.node_link import GraphvizError, program
from experiments.figures.diagrams.route import WIDEST_PT, Route, SystemSizeError
from prefplan import Automaton, Front, Plan, Problem, Scenario


def automata(problem: Problem) -> dict[str, str]:
    """Return the automaton of every task as HTML."""
    return {task.name: _automaton(one) for task, one in zip(problem.tasks, problem.automata, strict=True)}


def plans(scenario: Scenario, front: Front, folder: Path) -> dict[int, str]:
    """Return the plans that can be drawn, as HTML, by their number on the front.

    Pixels of maps are written to the folder of the page's parts, beside the page.
    """
    plan_map = maps.map_of(scenario)
    if plan_map is not None:
        return {i: maps.svg(plan_map, plan, folder=folder) for i, plan in enumerate(front)}
    routes = {i: _route(scenario, plan) for i, plan in enumerate(front)}
    return {
        i: node_link.svg(found.diagram, title=_words(found), widest=WIDEST_PT)
        for i, found in routes.items()
        if found is not None
    }


def graph_data(scenario: Scenario, plan: Plan) -> dict[str, Any] | None:
    """Return the page's data on a plan's picture on a graph, JSON-ready; None if there is no picture."""
    found = _route(scenario, plan)
    if found is None:
        return None
    return {"at": list(found.at), "note": found.note, "words": _words(found)}


def _automaton(found: Automaton) -> str:
    """Return an automaton's picture, its table without Graphviz, or a sentence if it is too large for both."""
    try:
        return node_link.svg(automaton.diagram(found), title=f"Automaton of {found.text}")
    except AutomatonSizeError as error:
        return f'<p class="small">No picture: {escape(str(error))}.</p>'
    except GraphvizError:
        return f"<pre>{escape(table_text(found))}</pre>"


def _route(scenario: Scenario, plan: Plan) -> Route | None:
    if scenario.model.kind != "graph" or program() is None:
        return None
    try:
        return route.route(scenario.problem().system, plan)
    except SystemSizeError:
        return None


def _words(found: Route) -> str:
    stops = [found.diagram.nodes[i].text[0] for i in dict.fromkeys(found.at)]
    visited = ", ".join(stops)
    return f"Graph of {len(found.diagram.nodes)} states with the plan on it; it visits {visited}"
