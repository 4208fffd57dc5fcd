"""`prefplan automaton`: the automaton of a formula."""

from __future__ import annotations

import argparse

from experiments.cli.arguments import Commands, add_command
from experiments.cli.console import Console
from experiments.cli.options import add_options
from experiments.cli.start import loading
from experiments.cli.status import DONE
from experiments.figures.diagrams import automaton_text
from prefplan.logic.dfa import automaton as minimal_automaton


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    examples = (
        "prefplan automaton 'F (grocer & F p2)'",
        "prefplan automaton '!pizza U cheese' --format dot",
    )
    parser = add_command(commands, automaton, *examples)
    parser.add_argument("formula", metavar="FORMULA", help="a co-safe formula, as Spot, Owl, SPIN or LTLf2DFA write it")
    parser.add_argument(
        "--format",
        choices=["table", *automaton_text.WRITERS],
        default="table",
        help="table to read, HOA for other tools, dot for Graphviz (default: table)",
    )
    add_options(parser, "--plot")


def automaton(options: argparse.Namespace) -> int:
    """Print the automaton of a formula."""
    found = minimal_automaton(options.formula)
    if options.plot is not None:
        with loading():
            from experiments.figures.diagrams.automaton import draw
            from experiments.figures.figures import picture_file
        draw({found.text: found}, picture_file(options.plot))
    if options.format == "table":
        automaton_text.show_table(Console(), found)
    else:
        print(automaton_text.WRITERS[options.format](found), end="")
    return DONE
