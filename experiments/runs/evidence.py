"""The log of an outcome, the claims in it, and its certificate."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

from experiments.cli.files import write_bytes, write_json
from experiments.cli.output import plan_json
from experiments.runs.certificates import certificate_json
from experiments.runs.outcome import Outcome
from prefplan.claims import Claims
from prefplan.scenario.decode import Scenario
from sim.evidence.certificate import certify
from sim.evidence.log import Log, encode, log_of, read_log
from sim.evidence.signature import sign
from sim.world.scene import Scene

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey


def prove(
    scenario: Scenario, scene: Scene, outcome: Outcome, path: Path, *, key: Ed25519PrivateKey | None = None
) -> Outcome:
    """Write the log of an outcome and the certificate of the written file; return the outcome with both.

    The log is `NAME.npz`; the certificate, `NAME.certificate.json`, lies beside it. Without a key it is not signed.

    Raises:
        PrefplanError: a file cannot be written.
    """
    contents = encode(evidence(scenario, scene, outcome))
    write_bytes(path, sign(contents, key) if key else contents)
    log = read_log(path)
    certificate = certify(log)
    write_json(path.with_suffix(".certificate.json"), certificate_json(log, certificate))
    return replace(outcome, log=path, certificate=certificate)


def evidence(scenario: Scenario, scene: Scene, outcome: Outcome) -> Log:
    """Return the log of an outcome, from which `sim.evidence.certificate` can check every claim about the run."""
    claims, setting = claims_of(outcome), outcome.setting
    return log_of(scene, outcome.run, claims, scenario=scenario.name, text=scenario.text, setting=setting)


def claims_of(outcome: Outcome) -> Claims:
    """Return the claims about a run; for a run that was not completed, the costs and relaxations so far."""
    said, completed = asdict(outcome.ledger.final), outcome.run.completed
    return Claims(
        completed=completed,
        **{key: said[key] for key in ("cost", "task_costs", "violation_costs")},
        preference=plan_json(outcome.plan)["preference"] if completed else None,
        relaxations=tuple(b for b in outcome.plan.relaxations if b.step <= len(outcome.run.steps)),
    )
