"""`prefplan verify`: the claims of a run, checked again from its log alone."""

from __future__ import annotations

import argparse
from pathlib import Path

import shtab

from experiments.cli import output
from experiments.cli.arguments import Commands, add_command
from experiments.cli.completion import complete, scenario_files
from experiments.cli.console import Console
from experiments.cli.options import add_options
from experiments.cli.start import loading
from experiments.cli.status import DONE, FAILED
from prefplan.scenario.decode import load


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    examples = (
        "prefplan run case_study_3 --no-video && prefplan verify out/case_study_3/cost.npz",
        "prefplan verify out/case_study_3/preference.npz --json",
        "prefplan verify out/case_study_3/cost.npz --scenario case_study_3 --resimulate --key public.pem",
    )
    parser = add_command(commands, verify, *examples)
    log = parser.add_argument("log", type=Path, metavar="LOG", help="log that `prefplan run` wrote, an .npz file")
    complete(log, shtab.glob("*.npz"))
    scenario = parser.add_argument("--scenario", metavar="FILE", help="also check that the log is of this scenario")
    complete(scenario, scenario_files())
    parser.add_argument("--resimulate", action="store_true", help="also simulate the run again from its commands")
    parser.add_argument(
        "--key", type=Path, metavar="FILE", help="also check the signature, with this public Ed25519 key"
    )
    add_options(parser, "--json")


def verify(options: argparse.Namespace) -> int:
    """Check every claim about a run from its log alone."""
    with loading():
        from experiments.runs.certificates import certificate_json, show_certificate
        from sim.evidence.certificate import certify
        from sim.evidence.log import read_log
        from sim.evidence.signature import check_signature, read_public_key

    key = read_public_key(options.key) if options.key else None
    scenario = load(options.scenario) if options.scenario else None
    log = read_log(options.log)
    signature = [check_signature(options.log.read_bytes(), key)] if key else []
    certificate = certify(log, scenario=scenario, again=options.resimulate, more=signature)
    asked = {"scenario": scenario, "resimulate": options.resimulate, "key": key}
    levels = ["plain", *(level for level, given in asked.items() if given)]
    if options.json:
        output.print_json(certificate_json(log, certificate, levels))
    else:
        show_certificate(Console(highlight=False), log, certificate, levels)
    return DONE if certificate.confirmed else FAILED
