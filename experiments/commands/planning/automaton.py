"""`prefplan automaton`: the automaton of a formula."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from experiments.cli import options
from experiments.cli.command import command
from experiments.cli.console import Console
from experiments.cli.status import DONE, say

if TYPE_CHECKING:
    from prefplan.limits import Limits


@command
@click.argument("formula", help="A co-safe formula, as Spot, Owl, SPIN or LTLf2DFA write it.")
@click.option(
    "--format",
    type=click.Choice(["table", "hoa", "dot"]),
    default="table",
    help="table to read, HOA for other tools, dot for Graphviz (default: table).",
)
@options.plot
@options.limits("exit status 4")
def automaton(formula: str, format: str, plot: str | None, limits: Limits) -> int:
    """Print the automaton of a formula.

    Examples:
      prefplan automaton 'F (grocer & F p2)'
      prefplan automaton '!pizza U cheese' --format dot
      prefplan automaton 'F[0:9] (a & F[0:9] b)' --max-seconds 10
    """
    from experiments.figures.diagrams import automaton_text, node_link
    from experiments.figures.diagrams.automaton import diagram
    from prefplan.logic.dfa import automaton as minimal_automaton

    with limits:
        found = minimal_automaton(formula)
        if plot is not None:
            from experiments.figures.figures import picture_file

            node_link.draw({found.text: diagram(found)}, picture_file(plot))
        if format == "table":
            automaton_text.show_table(Console(), found)
        elif format == "hoa":
            say(automaton_text.hoa(found), end="")
        else:
            say(node_link.source({found.text: diagram(found)}), end="")
    return DONE
