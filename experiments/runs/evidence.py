"""The log of an outcome, the claims in it, and its certificate."""

from __future__ import annotations

import hashlib
from dataclasses import asdict, replace
from pathlib import Path

from experiments.cli.files import write_bytes, write_json
from experiments.cli.output import plan_json
from experiments.runs.certificates import certificate_json
from experiments.runs.outcome import Outcome
from prefplan.claims import Claims
from prefplan.scenario.decode import Scenario
from sim.evidence.certificate import Certificate, certify
from sim.evidence.log import Log, encode, log_of, read_log
from sim.world.scene import Scene


def prove(scenario: Scenario, scene: Scene, outcome: Outcome, path: Path) -> Outcome:
    """Write the log of an outcome and the certificate of the written file; return the outcome with both.

    The log is `NAME.npz`; the certificate, `NAME.certificate.json`, lies beside it and names the log's SHA-256. Ctrl-C
    while the log is checked leaves an outcome that is interrupted, and a certificate that says so.

    Raises:
        PrefplanError: a file cannot be written.
    """
    record = path.with_suffix(".certificate.json")
    record.unlink(missing_ok=True)
    write_bytes(path, encode(evidence(scenario, scene, outcome)))
    outcome = replace(outcome, log=path)
    try:
        return replace(outcome, certificate=certified(scenario, path))
    except KeyboardInterrupt:
        write_json(record, {"verdict": None, "interrupted": True, "log_sha256": digest_of(path)})
        return replace(outcome, interrupted=True)


def certified(scenario: Scenario, path: Path) -> Certificate:
    """Check a log's file in a scenario, and write its certificate beside it.

    Raises:
        PrefplanError: the log cannot be read, or the certificate not be written.
    """
    log = read_log(path)
    certificate = certify(log, scenario=scenario)
    write_json(path.with_suffix(".certificate.json"), certificate_json(log, certificate, log_sha256=digest_of(path)))
    return certificate


def digest_of(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def evidence(scenario: Scenario, scene: Scene, outcome: Outcome) -> Log:
    """Return the log of an outcome, from which `sim.evidence.certificate` can check every claim about the run."""
    claims, setting = claims_of(outcome), outcome.setting | ({"interrupted": True} if outcome.interrupted else {})
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
