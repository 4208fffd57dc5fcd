"""`prefplan doctor`: what works on this machine, and what mends the rest."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from importlib.util import find_spec

from rich.text import Text

from experiments.cli import output
from experiments.cli.arguments import Commands, add_command, add_json
from experiments.cli.console import Console
from experiments.cli.progress import Bars
from experiments.cli.status import DONE, FAILED
from experiments.doctor import diagnosis, gl_backends
from experiments.doctor.diagnosis import OK, PROBLEM, WARNING, Check, Diagnosis

CHECKS: tuple[Check, ...] = (
    diagnosis.python,
    diagnosis.packages,
    diagnosis.planner,
    diagnosis.simulation,
    gl_backends.rendering,
    diagnosis.ffmpeg,
    diagnosis.meshes,
    diagnosis.cores,
    diagnosis.memory,
    diagnosis.browser,
    diagnosis.extras,
)
"""In the order of the output."""

SIMULATION = (diagnosis.simulation, gl_backends.rendering, diagnosis.ffmpeg, diagnosis.meshes)
"""Checks of what is optional; whether it is there at all is found among the extras."""

COLOURS = {OK: "green", WARNING: "yellow", PROBLEM: "bold red"}

GAP = "  "


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    summary = "Say what works on this machine, and which command mends what does not."
    more = "The exit status is 4 if something needed does not work. What is optional and missing is a warning."
    parser = add_command(commands, doctor, summary, "prefplan doctor", "prefplan doctor --json", more=more)
    add_json(parser)


def doctor(options: argparse.Namespace) -> int:
    """Carry out `prefplan doctor`."""
    console = Console(highlight=False)
    found: list[Diagnosis] = []
    checks = [check for check in CHECKS if check not in SIMULATION or find_spec("mujoco")]
    with Bars() as bars:
        for done, check in enumerate(checks):
            bars("checking", done, len(checks), check.__name__)
            found += check()
    well = all(finding.status != PROBLEM for finding in found)
    if options.json:
        output.print_json({"well": well, "findings": [asdict(finding) for finding in found]})
    else:
        wide = max(len(finding.name) for finding in found)
        for finding in found:
            _show(console, finding, wide)
    return DONE if well else FAILED


def _show(console: Console, finding: Diagnosis, wide: int) -> None:
    status = Text(f"{finding.status:<{len(PROBLEM)}}", style=COLOURS[finding.status])
    console.print(Text.assemble(status, GAP, (f"{finding.name:<{wide}}", "bold"), GAP, finding.found))
    if finding.mend:
        indent = " " * (len(PROBLEM) + len(GAP) + wide + len(GAP))
        console.print(Text(f"{indent}mend: {finding.mend}"))
