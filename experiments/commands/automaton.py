"""`prefplan automaton`: a task's automaton."""

from __future__ import annotations

import argparse

from experiments import automaton_formats
from experiments.arguments import Commands, add_command
from experiments.console import Console
from experiments.start import loading
from experiments.status import DONE
from prefplan.automaton import automaton as minimal_automaton


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    summary = "Print a task's automaton."
    examples = (
        "prefplan automaton 'F (grocer & F p2)'",
        "prefplan automaton '!pizza U cheese' --format dot",
    )
    parser = add_command(commands, automaton, summary, *examples)
    parser.add_argument("formula", metavar="FORMULA", help="a co-safe formula of ! & | -> X F U, names, true, false")
    parser.add_argument(
        "--format",
        choices=["table", *automaton_formats.WRITERS],
        default="table",
        help="for people, for other tools, or for Graphviz (default: table)",
    )
    parser.add_argument("--plot", metavar="FILE", help="draw it too; the file ends in .png, .svg or .pdf")


def automaton(options: argparse.Namespace) -> int:
    """Carry out `prefplan automaton`."""
    found = minimal_automaton(options.formula)
    if options.plot is not None:
        with loading():
            from experiments.pictures.automaton import draw
            from experiments.pictures.figures import picture_file
        draw({found.text: found}, picture_file(options.plot))
    if options.format == "table":
        automaton_formats.show_table(Console(), found)
    else:
        print(automaton_formats.WRITERS[options.format](found), end="")
    return DONE
