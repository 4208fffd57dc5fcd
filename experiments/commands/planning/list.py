"""`prefplan list`: the scenarios that ship."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from rich.table import Table
from rich.text import Text

from experiments import scenarios
from experiments.cli import output
from experiments.cli.arguments import Commands, add_command, add_json
from experiments.cli.console import Console
from experiments.cli.overview import overview
from experiments.cli.status import DONE

HEADINGS = ("scenario", "model", "tasks", "contract")

FRAME = 3
"""Width that a table adds to a column: a line and two blanks."""

SHORTEST = 20
"""Least length of a sentence on a narrow terminal."""


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    summary = "List the scenarios that ship, one line each."
    more = "A narrow terminal cuts the sentences; --json has all of them.\n"
    more += "Every other command takes these names. `prefplan init` starts a scenario of your own."
    parser = add_command(commands, list_, summary, "prefplan list", "prefplan list --json", more=more)
    add_json(parser)


def list_(options: argparse.Namespace) -> int:
    """Carry out `prefplan list`."""
    found = [overview(scenarios.find(name, measured=False)) for name in scenarios.names()]
    if options.json:
        output.print_json({"scenarios": [asdict(one) for one in found]})
        return DONE
    console = Console(highlight=False)
    rows = [(one.name, one.kind, str(one.tasks), one.contract) for one in found]
    taken = sum(max(map(len, column)) + FRAME for column in zip(HEADINGS, *rows, strict=True))
    width = max(SHORTEST, console.width - taken - FRAME - 1)
    table = Table()
    for heading in HEADINGS:
        table.add_column(heading, no_wrap=True, justify="right" if heading == "tasks" else "left")
    table.add_column("what it is about", no_wrap=True)
    for row, one in zip(rows, found, strict=True):
        summary = Text(one.summary)
        summary.truncate(width, overflow="ellipsis")
        table.add_row(*row, summary)
    console.print(table)
    return DONE
