"""`prefplan doctor`: what works on this machine, and which command repairs what does not."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from rich.text import Text

from experiments.cli import output
from experiments.cli.arguments import Commands, add_command
from experiments.cli.console import Console
from experiments.cli.options import add_options
from experiments.cli.progress import Bars
from experiments.cli.status import DONE, FAILED
from experiments.commands.machine import diagnosis
from experiments.commands.machine.diagnosis import OK, PROBLEM, WARNING, Diagnosis

COLOURS = {OK: "green", WARNING: "yellow", PROBLEM: "bold red"}

GAP = "  "


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    more = "The exit status is 4 if a needed part does not work. A missing optional part is a warning."
    parser = add_command(commands, doctor, "prefplan doctor", "prefplan doctor --json", more=more)
    add_options(parser, "--json")


def doctor(options: argparse.Namespace) -> int:
    """Check what works on this machine, and print the command that repairs what does not."""
    found: list[Diagnosis] = []
    checks = list(diagnosis.CHECKS)
    with Bars(quiet=options.quiet) as bars:
        for check in checks:
            bars("checking", len(found), len(checks), check.__name__)
            found.append(check())
            if check is diagnosis.simulation and found[-1].status == OK:
                checks += diagnosis.SIMULATION_CHECKS
    well = all(finding.status != PROBLEM for finding in found)
    if options.json:
        output.print_json({"well": well, "findings": [asdict(finding) for finding in found]})
    else:
        _show(Console(highlight=False), found)
    return DONE if well else FAILED


def _show(console: Console, found: list[Diagnosis]) -> None:
    width = max(len(finding.name) for finding in found)
    indent = " " * (len(PROBLEM) + len(GAP) + width + len(GAP))
    for finding in found:
        status = Text(f"{finding.status:<{len(PROBLEM)}}", style=COLOURS[finding.status])
        console.print(Text.assemble(status, GAP, (f"{finding.name:<{width}}", "bold"), GAP, finding.found))
        if finding.mend:
            console.print(Text(f"{indent}mend: {finding.mend}"))
