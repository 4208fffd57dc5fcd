"""`prefplan verify`: the claims of a run, checked again from its log alone."""

from __future__ import annotations

from pathlib import Path

import click

import prefplan as pp
from experiments import scenarios
from experiments.cli import options, output
from experiments.cli.command import command
from experiments.cli.console import Console
from experiments.cli.start import loading
from experiments.cli.status import DONE, FAILED
from experiments.cli.values import PATH, FileName


@command
@click.argument("log", type=FileName(".npz"), help="Log that `prefplan run` wrote, an .npz file.")
@click.option(
    "--scenario",
    type=FileName(".toml", scenarios.names),
    metavar="FILE",
    help="Also check that the log is of this scenario.",
)
@click.option("--resimulate", is_flag=True, help="Also simulate the run again from its commands.")
@click.option("--key", type=PATH, metavar="FILE", help="Also check the signature, with this public Ed25519 key.")
@options.as_json
def verify(log: str, scenario: str | None, resimulate: bool, key: Path | None, as_json: bool) -> int:
    """Check every claim about a run from its log alone.

    Examples:
      prefplan run case_study_3 --no-video && prefplan verify out/case_study_3/cost.npz
      prefplan verify out/case_study_3/preference.npz --json
      prefplan verify out/case_study_3/cost.npz --scenario case_study_3 --resimulate --key public.pem
    """
    with loading():
        from experiments.runs.certificates import certificate_json, show_certificate
        from sim.evidence.certificate import certify
        from sim.evidence.log import read_log
        from sim.evidence.signature import check_signature, read_public_key

    path = Path(log)
    public_key = read_public_key(key) if key else None
    loaded = pp.load(scenario) if scenario else None
    run = read_log(path)
    signature = [check_signature(path.read_bytes(), public_key)] if public_key else []
    certificate = certify(run, scenario=loaded, again=resimulate, more=signature)
    asked = {"scenario": scenario, "resimulate": resimulate, "key": key}
    levels = ["plain", *(level for level, given in asked.items() if given)]
    if as_json:
        output.print_json(certificate_json(run, certificate, levels))
    else:
        show_certificate(Console(highlight=False), run, certificate, levels)
    return DONE if certificate.confirmed else FAILED
