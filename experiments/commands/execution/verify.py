"""`prefplan verify`: the claims of a run, checked again from its log alone."""

from __future__ import annotations

import argparse
from pathlib import Path

import shtab

from experiments.cli import output
from experiments.cli.arguments import Commands, add_command, add_json
from experiments.cli.completion import complete
from experiments.cli.console import Console
from experiments.cli.start import loading
from experiments.cli.status import DONE, FAILED


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    summary = "Check the claims of a run again, from its log alone."
    examples = (
        "prefplan run case_study_3 --no-video && prefplan verify out/case_study_3/cost.npz",
        "prefplan verify out/case_study_3/preference.npz --json",
    )
    parser = add_command(commands, verify, summary, *examples)
    log = parser.add_argument("log", type=Path, metavar="LOG", help="log that `prefplan run` wrote, an .npz file")
    complete(log, shtab.glob("*.npz"))
    add_json(parser)


def verify(options: argparse.Namespace) -> int:
    """Carry out `prefplan verify`."""
    with loading():
        from experiments.runs.certificates import certificate_json, show_certificate
        from sim.evidence.certificate import certify
        from sim.evidence.log import read_log

    log = read_log(options.log)
    certificate = certify(log)
    if options.json:
        output.print_json(certificate_json(log, certificate))
    else:
        show_certificate(Console(highlight=False), log, certificate)
    return DONE if certificate.confirmed else FAILED
