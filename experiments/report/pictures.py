"""The pictures of a page that are drawn in advance: automata, and plans on maps and graphs."""

from __future__ import annotations

import base64
import hashlib
import re
from html import escape
from pathlib import Path
from typing import Any

from experiments.cli.files import write_bytes
from experiments.figures import maps
from experiments.figures.diagrams import automaton, route
from experiments.figures.diagrams.guards import AutomatonSizeError
from experiments.figures.diagrams.route import Route
from experiments.figures.diagrams.system import SystemSizeError
from prefplan.front import Front
from prefplan.logic.dfa import Automaton
from prefplan.plan import Plan
from prefplan.problem import Problem
from prefplan.scenario.decode import Scenario

INLINE_PIXELS = re.compile(r"data:image/png;base64,([A-Za-z0-9+/=\s]+)")


def automata(problem: Problem) -> dict[str, str]:
    """Return the automaton of every task as HTML."""
    return {task.name: _automaton(one) for task, one in zip(problem.tasks, problem.automata, strict=True)}


def plans(scenario: Scenario, front: Front, folder: Path) -> dict[int, str]:
    """Return the plans that can be drawn, as HTML, by their number on the front.

    Pixels of maps are written to the folder of the page's parts, beside the page.
    """
    plan_map = maps.map_of(scenario)
    if plan_map is not None:
        return {i: _with_files(maps.svg(plan_map, plan), folder) for i, plan in enumerate(front)}
    routes = {i: _route(scenario, plan) for i, plan in enumerate(front)}
    return {i: route.svg(found, title=_words(found)) for i, found in routes.items() if found is not None}


def graph_data(scenario: Scenario, plan: Plan) -> dict[str, Any] | None:
    """Return the page's data on a plan's picture on a graph, JSON-ready; None if there is no picture."""
    found = _route(scenario, plan)
    if found is None:
        return None
    return {"at": list(found.at), "note": found.note, "words": _words(found)}


def _with_files(svg: str, folder: Path) -> str:
    """Write the pixels of a picture to files, so that maps with the same background share one."""

    def written(match: re.Match[str]) -> str:
        pixels = base64.b64decode(match[1])
        file = folder / f"{hashlib.sha256(pixels).hexdigest()[:12]}.png"
        if not file.exists():
            write_bytes(file, pixels)
        return f"{folder.name}/{file.name}"

    return INLINE_PIXELS.sub(written, svg)


def _automaton(found: Automaton) -> str:
    """Return an automaton's picture, or a sentence if it is too large to draw."""
    try:
        return automaton.svg(found)
    except AutomatonSizeError as error:
        return f'<p class="small">No picture: {escape(str(error))}.</p>'


def _route(scenario: Scenario, plan: Plan) -> Route | None:
    if scenario.model.kind != "graph":
        return None
    try:
        return route.route(scenario.problem().system, plan)
    except SystemSizeError:
        return None


def _words(found: Route) -> str:
    stops = [found.nodes[i].text[0] for i in dict.fromkeys(found.at)]
    visited = ", ".join(stops)
    return f"Graph of {len(found.nodes)} states with the plan on it; it visits {visited}"
