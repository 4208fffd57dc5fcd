"""`prefplan doctor`: what works on this machine, and which command repairs what does not."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

from rich.text import Text

from experiments.cli import options, output
from experiments.cli.command import command
from experiments.cli.console import Console
from experiments.cli.progress import Bars
from experiments.cli.status import DONE, FAILED

if TYPE_CHECKING:
    from experiments.checks.diagnosis import Diagnosis

GAP = "  "


@command
@options.as_json
def doctor(as_json: bool) -> int:
    """Check what works on this machine, and print the command that repairs what does not.

    Examples:
      prefplan doctor
      prefplan doctor --json

    The exit status is 4 if a needed part does not work. A missing optional part is a warning.
    """
    from experiments.checks import diagnosis

    found: list[Diagnosis] = []
    checks = list(diagnosis.CHECKS)
    with Bars() as bars:
        for check in checks:
            bars("checking", len(found), len(checks), check.__name__)
            found.append(check())
            if check is diagnosis.simulation and found[-1].status == diagnosis.OK:
                checks += diagnosis.SIMULATION_CHECKS
    well = all(finding.status != diagnosis.PROBLEM for finding in found)
    if as_json:
        output.print_json({"well": well, "findings": [asdict(finding) for finding in found]})
    else:
        _show(Console(), found)
    return DONE if well else FAILED


def _show(console: Console, found: list[Diagnosis]) -> None:
    colours = {"ok": "green", "warning": "yellow", "problem": "bold red"}
    wide = max(map(len, colours))
    width = max(len(finding.name) for finding in found)
    indent = " " * (wide + len(GAP) + width + len(GAP))
    for finding in found:
        status = f"{finding.status:<{wide}}", colours[finding.status]
        console.print(Text.assemble(status, GAP, (f"{finding.name:<{width}}", "bold"), GAP, finding.found))
        if finding.fix:
            console.print(f"{indent}fix: {finding.fix}")
