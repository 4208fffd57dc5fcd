"""`prefplan draw`: pictures of a scenario's plans, automata and transition system."""

from __future__ import annotations

import argparse
from pathlib import Path

from experiments.cli.arguments import Commands, add_command
from experiments.cli.options import add_options
from experiments.cli.start import loading, tell_if_compiling
from experiments.cli.status import DONE, no_plan
from prefplan.errors import ScenarioError, prefixed
from prefplan.logic.dfa import automaton
from prefplan.planner import Planner
from prefplan.scenario.decode import Scenario, load


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    examples = ("prefplan draw plans case_study_1 plans.pdf", "prefplan draw automata case_study_2 automata.svg")
    parser = add_command(commands, draw, *examples)
    parser.add_argument(
        "what",
        metavar="WHAT",
        choices=list(PICTURES),
        help="plans: each plan of the front on its map or graph; automata: one for each task; system: a small model",
    )
    add_options(parser, "scenario")
    parser.add_argument("file", metavar="FILE", help="the picture to write; it ends in .png, .svg or .pdf")
    add_options(parser, "--max-cost")


def draw(options: argparse.Namespace) -> int:
    """Draw a scenario's plans, its tasks' automata or its transition system."""
    with loading():
        from experiments.figures.figures import picture_file
    path = picture_file(options.file)
    status = PICTURES[options.what](load(options.scenario), path, options)
    if status == DONE:
        print(path)
    return status


def _plans(scenario: Scenario, path: Path, options: argparse.Namespace) -> int:
    from experiments.figures import plans
    from experiments.figures.diagrams import route, system
    from experiments.figures.maps import map_of

    if scenario.model.kind == "manipulation":
        raise ScenarioError(
            f"{scenario.path}: model.kind: only the plans of a grid or graph model can be drawn; "
            "`prefplan report` shows those of any model"
        )
    tell_if_compiling(quiet=options.quiet)
    problem = scenario.problem()
    front = Planner(problem).front(max_cost=options.max_cost)
    if front.reason:
        return no_plan(front.reason, problem)
    if map_of(scenario) is not None:
        plans.draw(scenario, front, path)
        return DONE
    with prefixed(f"{scenario.path}: ", system.SystemSizeError):
        route.draw(scenario.problem().system, front, path)
    return DONE


def _automata(scenario: Scenario, path: Path, options: argparse.Namespace) -> int:
    from experiments.figures.diagrams import automaton as picture

    scenario.problem()
    picture.draw(
        {f"{task.label or task.name}: {task.formula}": automaton(task.formula) for task in scenario.tasks}, path
    )
    return DONE


def _system(scenario: Scenario, path: Path, options: argparse.Namespace) -> int:
    from experiments.figures.diagrams import node_link, system

    with prefixed(f"{scenario.path}: model: ", system.SystemSizeError):
        diagram = system.diagram(scenario.problem().system)
    node_link.draw({scenario.name: diagram}, path)
    return DONE


PICTURES = {"plans": _plans, "automata": _automata, "system": _system}
"""Pictures by name."""
