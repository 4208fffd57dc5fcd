"""`prefplan draw`: pictures of a scenario's plans and automata."""

from __future__ import annotations

from decimal import Decimal
from typing import TYPE_CHECKING

import click

import prefplan as pp
from experiments.checks.no_plan import no_plan
from experiments.cli import options
from experiments.cli.choice import bounds_of
from experiments.cli.command import command
from experiments.cli.start import load_planner
from experiments.cli.status import DONE, say, tell
from prefplan.errors import ScenarioError

if TYPE_CHECKING:
    from prefplan.limits import Limits


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
@options.at_most
@options.limits("the plans found by then")
def draw(
    what: str, scenario: str, file: str, max_cost: Decimal | None, at_most: dict[str, Decimal], limits: Limits
) -> int:
    """Draw a scenario's plans or its tasks' automata.

    Examples:
      prefplan draw plans case_study_1 plans.pdf
      prefplan draw automata case_study_2 automata.svg
    """
    from experiments.figures import plans
    from experiments.figures.diagrams import automaton, node_link
    from experiments.figures.figures import picture_file

    path = picture_file(file)
    with limits:
        loaded = pp.load(scenario)
        if what == "automata":
            problem = loaded.problem()
            titles = [f"{task.label or task.name}: {task.formula}" for task in problem.tasks]
            node_link.draw(dict(zip(titles, map(automaton.diagram, problem.automata), strict=True)), path)
            say(path)
            return DONE
        if loaded.model.kind == "manipulation":
            raise ScenarioError(
                f"{loaded.path}: model.kind: only the plans of a grid or graph model can be drawn; "
                "`prefplan report` shows those of any model"
            )
        load_planner()
        planner = pp.Planner(loaded.problem())
        front = planner.front(max_cost=max_cost, at_most=bounds_of(planner.problem, at_most))
    if front.reason:
        return no_plan(front.reason, planner)
    if front:
        plans.draw(loaded, front, path)
        say(path)
    if front.ended:
        tell(front.ending)
    return DONE
