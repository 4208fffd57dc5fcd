"""`prefplan draw`: pictures of a scenario's plans and automata."""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path

import click

import prefplan as pp
from experiments.checks.no_plan import no_plan
from experiments.cli import options
from experiments.cli.command import command, is_quiet
from experiments.cli.start import load_planner
from experiments.cli.status import DONE, say
from prefplan.errors import ScenarioError


@command
@click.argument(
    "what",
    metavar="WHAT",
    type=click.Choice(["plans", "automata"]),
    help="plans: each plan of the front on its map or graph; automata: one for each task.",
)
@options.scenario
@click.argument("file", type=click.Path(), help="The picture to write; it ends in .png, .svg or .pdf.")
@options.max_cost
def draw(what: str, scenario: str, file: str, max_cost: Decimal | None) -> int:
    """Draw a scenario's plans or its tasks' automata.

    Examples:
      prefplan draw plans case_study_1 plans.pdf
      prefplan draw automata case_study_2 automata.svg
    """
    from experiments.figures.figures import picture_file

    path, loaded = picture_file(file), pp.load(scenario)
    status = _automata(loaded, path) if what == "automata" else _plans(loaded, path, max_cost)
    if status == DONE:
        say(path)
    return status


def _automata(scenario: pp.Scenario, path: Path) -> int:
    from experiments.figures.diagrams import automaton, node_link

    problem = scenario.problem()
    titles = [f"{task.label or task.name}: {task.formula}" for task in problem.tasks]
    node_link.draw(dict(zip(titles, map(automaton.diagram, problem.automata), strict=True)), path)
    return DONE


def _plans(scenario: pp.Scenario, path: Path, max_cost: Decimal | None) -> int:
    """Draw the plans of a scenario, and return the exit status."""
    from experiments.figures import plans

    if scenario.model.kind == "manipulation":
        raise ScenarioError(
            f"{scenario.path}: model.kind: only the plans of a grid or graph model can be drawn; "
            "`prefplan report` shows those of any model"
        )
    load_planner(quiet=is_quiet())
    planner = pp.Planner(scenario.problem())
    front = planner.front(max_cost=max_cost)
    if front.reason:
        return no_plan(front.reason, planner)
    plans.draw(scenario, front, path)
    return DONE
