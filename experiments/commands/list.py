"""`prefplan list`: the scenarios that ship."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from rich.table import Table
from rich.text import Text

from experiments import output, scenarios
from experiments.arguments import Commands, add_command, add_json
from experiments.console import Console
from experiments.overview import overview
from experiments.status import DONE


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    summary = "List the scenarios that ship, one line each."
    more = "A terminal that is too narrow shows the beginnings of the sentences; --json has them whole.\n"
    more += "Any other command takes these names. A scenario of your own is begun by `prefplan init`."
    parser = add_command(commands, list_, summary, "prefplan list", "prefplan list --json", more=more)
    add_json(parser)


def list_(options: argparse.Namespace) -> int:
    """Carry out `prefplan list`."""
    found = [overview(scenarios.find(name, measured=False)) for name in scenarios.names()]
    if options.json:
        output.print_json({"scenarios": [asdict(one) for one in found]})
        return DONE
    table = Table()
    table.add_column("scenario", style="bold")
    table.add_column("model")
    table.add_column("tasks", justify="right")
    table.add_column("contract")
    table.add_column("what it is about", no_wrap=True, overflow="ellipsis")
    for one in found:
        table.add_row(one.name, one.kind, str(one.tasks), one.contract, Text(one.summary))
    Console(highlight=False).print(table)
    return DONE
