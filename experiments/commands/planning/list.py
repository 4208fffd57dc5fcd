"""`prefplan list`: the scenarios that ship."""

from __future__ import annotations

import argparse
from typing import Any

from rich.table import Table
from rich.text import Text

from experiments import scenarios
from experiments.cli import output
from experiments.cli.arguments import Commands, add_command
from experiments.cli.console import UNLIMITED, Console
from experiments.cli.options import add_options
from experiments.cli.overview import first_sentence
from experiments.cli.status import DONE
from prefplan.preferences.objective import Measure
from prefplan.scenario.decode import Scenario, load


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    more = "Other commands accept these names as SCENARIO. `prefplan init` starts a scenario of your own."
    parser = add_command(commands, list_, "prefplan list", "prefplan list --json", more=more)
    add_options(parser, "--json")


def list_(options: argparse.Namespace) -> int:
    """List the scenarios that ship, and what each is about."""
    found = [_entry(load(name, measured=False)) for name in scenarios.names()]
    if options.json:
        output.print_json({"scenarios": found})
        return DONE
    table = Table()
    table.add_column("scenario", no_wrap=True, style="bold")
    table.add_column("what it is about")
    for one in found:
        table.add_row(one["name"], Text.assemble(one["summary"], (f" ({one['kind']}, {one['tasks']} tasks)", "dim")))
    console = Console(highlight=False)
    unwrapped = console.measure(table, options=console.options.update(max_width=UNLIMITED)).maximum
    table.show_lines = unwrapped > console.width
    console.print(table)
    return DONE


def _entry(scenario: Scenario) -> dict[str, Any]:
    """Return the entry of a scenario, without building its transition system."""
    names = [task.name for task in scenario.tasks]
    return {
        "name": scenario.name,
        "kind": scenario.model.kind,
        "tasks": len(names),
        "contract": Measure.of(scenario.preference.terms(names), len(names)).contract,
        "summary": first_sentence(scenario.text),
    }
