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


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    summary = "List the scenarios that ship, and what each is about."
    more = "Every other command takes these names. `prefplan init` starts a scenario of your own."
    parser = add_command(commands, list_, summary, "prefplan list", "prefplan list --json", more=more)
    add_json(parser)


def list_(options: argparse.Namespace) -> int:
    """Carry out `prefplan list`."""
    found = [overview(scenarios.find(name, measured=False)) for name in scenarios.names()]
    if options.json:
        output.print_json({"scenarios": [asdict(one) for one in found]})
        return DONE
    table = Table()
    table.add_column("scenario", no_wrap=True, style="bold")
    table.add_column("what it is about")
    for one in found:
        table.add_row(one.name, Text.assemble(one.summary, (f" ({one.kind}, {one.tasks} tasks)", "dim")))
    Console(highlight=False).print(table)
    return DONE
