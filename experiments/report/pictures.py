"""The pictures of a page that are drawn in advance: automata, and plans on maps and graphs."""

from contextlib import suppress
from html import escape
from pathlib import Path

from experiments.figures import maps
from experiments.figures.diagrams import automaton, node_link, route
from experiments.figures.diagrams.automaton_text import table_text
from experiments.figures.diagrams.guards import AutomatonSizeError
from experiments.figures.diagrams.node_link import GraphvizError, program
from experiments.figures.diagrams.route import Route, SystemSizeError
from experiments.report.differences import landmarks
from prefplan import Front, GridModel, Ledger, Plan, Problem, Scenario
from prefplan.text.layout import counted


def automata(problem: Problem) -> dict[str, str]:
    """Return every task's automaton as HTML, by `automaton-TASK`.

    It is a picture, a table without Graphviz, or a sentence if it is too large.
    """
    found = {}
    for task, one in zip(problem.tasks, problem.automata, strict=True):
        name = f"automaton-{task.name}"
        try:
            found[name] = node_link.svg(automaton.diagram(one), title=f"Automaton of {one.text}")
        except AutomatonSizeError as error:
            found[name] = f'<p class="small">No picture: {escape(str(error))}.</p>'
        except GraphvizError:
            found[name] = f"<pre>{escape(table_text(one))}</pre>"
    return found


def plans(scenario: Scenario, front: Front, folder: Path) -> dict[str, str]:
    """Return the plans that can be drawn, as HTML, by `map-I` where I is their number on the front.

    Pixels of maps are written to the folder of the page's parts, beside the page.
    """
    plan_map = maps.map_of(scenario)
    if plan_map is not None:
        return {
            f"map-{i}": maps.svg(plan_map, plan, title=_map_words(scenario, plan), folder=folder)
            for i, plan in enumerate(front)
        }
    return {
        f"map-{i}": node_link.svg(found.diagram, title=found.words, direction="TB")
        for i, found in routes(scenario, front).items()
    }


def _map_words(scenario: Scenario, plan: Plan) -> str:
    """Return what a plan's map shows, for readers who cannot see it."""
    ground = "Map"
    if isinstance(scenario.model, GridModel):
        ground += " of {} by {} cells".format(*scenario.model.size)
    passed = ", ".join(landmarks(Ledger.of_plan(scenario.problem(), plan))) or "no region of a task"
    return f"{ground} with the robot's path of {counted(len(plan.actions), 'move')} through {passed}."


def routes(scenario: Scenario, front: Front) -> dict[int, Route]:
    """Return the plans that can be drawn on a graph, by their number on the front."""
    found: dict[int, Route] = {}
    if scenario.model.kind == "graph" and program() is not None:
        for i, plan in enumerate(front):
            with suppress(SystemSizeError):
                found[i] = route.route(scenario.problem().system, plan)
    return found
