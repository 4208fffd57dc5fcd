"""The log of an outcome, the claims in it, and its certificate."""

from dataclasses import asdict, replace
from pathlib import Path

from experiments.cli.files import write_bytes, write_json
from experiments.cli.output import plan_json
from experiments.runs.certificates import Proof, certificate_json
from experiments.runs.outcome import Outcome
from prefplan.claims import Claims
from prefplan.scenario.decode import Scenario
from sim.evidence.certificate import certify
from sim.evidence.log import Log, encode, log_of, read_log


def prove(outcome: Outcome, path: Path) -> Outcome:
    """Write the log of an outcome and the certificate of the written file; return the outcome with both.

    The log is `NAME.npz`; the certificate, `NAME.certificate.json`, lies beside it and names the log's SHA-256. Ctrl-C
    while the log is checked leaves an outcome that is interrupted, and a certificate that says so.

    Raises:
        PrefplanError: a file cannot be written.
    """
    path.with_suffix(".certificate.json").unlink(missing_ok=True)
    write_bytes(path, encode(evidence(outcome)))
    proof = proof_of(outcome.scenario, path)
    return replace(outcome, proof=proof, interrupted=outcome.interrupted or proof.certificate is None)


def proof_of(scenario: Scenario, path: Path) -> Proof:
    """Check a log's file in a scenario, unless the user ends the check, and write its certificate beside it.

    Raises:
        PrefplanError: the log cannot be read, or the certificate not be written.
    """
    proof = Proof(path, read_log(path), None)
    try:
        proof = replace(proof, certificate=certify(proof.log, scenario=scenario))
    except KeyboardInterrupt:
        pass
    write_json(path.with_suffix(".certificate.json"), certificate_json(proof))
    return proof


def evidence(outcome: Outcome) -> Log:
    """Return the log of an outcome, from which `sim.evidence.certificate` can check every claim about the run."""
    scenario, setting = outcome.scenario, outcome.setting | ({"interrupted": True} if outcome.interrupted else {})
    claims = claims_of(outcome)
    return log_of(outcome.scene, outcome.run, claims, scenario=scenario.name, text=scenario.text, setting=setting)


def claims_of(outcome: Outcome) -> Claims:
    """Return the claims about a run; for a run that was not completed, the costs and relaxations so far."""
    said, completed = asdict(outcome.ledger.final), outcome.run.completed
    return Claims(
        completed=completed,
        **{key: said[key] for key in ("cost", "task_costs", "violation_costs")},
        preference=plan_json(outcome.plan)["preference"] if completed else None,
        relaxations=outcome.relaxations,
    )
