"""`prefplan verify`: the claims of a run, checked again from its log."""

from pathlib import Path

import click

import prefplan as pp
from experiments import scenarios
from experiments.cli import options, output
from experiments.cli.command import command
from experiments.cli.console import Console
from experiments.cli.start import loading_simulation
from experiments.cli.status import CONSISTENT, DONE, FAILED
from experiments.cli.values import files

STATUS = {"proved": DONE, "consistent": CONSISTENT, "refuted": FAILED}
"""Exit status of each verdict."""


@command
@click.argument("log", shell_complete=files(".npz"), help="Log that `prefplan run` wrote, an .npz file.")
@click.option(
    "--scenario",
    shell_complete=files(".toml", scenarios.names),
    metavar="FILE",
    help="Scenario in which the run is simulated again; without it, the one that the log says it is of.",
)
@click.option(
    "--require",
    type=click.Choice(("consistent", "proved")),
    help="Exit with status 0 if the verdict is at least this one, else with 4.",
)
@options.as_json
def verify(log: str, scenario: str | None, require: str | None, as_json: bool) -> int:
    """Check every claim about a run from its log, and simulate its commands again.

    Examples:
      prefplan verify out/case_study_3/cost.npz --scenario case_study_3 --require proved
      prefplan verify out/case_study_3/preference.npz --json

    proved (status 0): the commands lead to every recorded digit in the scenario that you give, and the claims hold.

    consistent (status 5): no claim is contradicted, but you gave no scenario, or this machine or its MuJoCo is
    another, so that frames are compared within tolerances.

    refuted (status 4): a claim is contradicted; the lines marked NO say where.
    """
    with loading_simulation():
        from experiments.runs.certificates import Proof, certificate_json, show_certificate
        from sim.evidence.certificate import VERDICTS, certify
        from sim.evidence.log import read_log

    path = Path(log)
    loaded = pp.load(scenario) if scenario else None
    run = read_log(path)
    certificate = certify(run, scenario=loaded)
    if as_json:
        output.print_json(certificate_json(Proof(path, run, certificate)))
    else:
        show_certificate(Console(), run, certificate, given=loaded.name if loaded else None)
    if require is None:
        return STATUS[certificate.verdict]
    return DONE if VERDICTS.index(certificate.verdict) >= VERDICTS.index(require) else FAILED
