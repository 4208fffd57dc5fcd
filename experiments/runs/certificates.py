"""Certificates as text and as JSON."""

from dataclasses import asdict, dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.text import Text

from prefplan.claims import Check
from prefplan.text.layout import printable
from sim import Certificate, Log

MEANING = {
    "proved": "the commands lead to the recorded states in the given scenario, and the claims follow from these",
    "consistent": "nothing found contradicts the claims",
}
"""What a verdict says."""

OPEN = "that the sensor saw what the log says, or that anything happened outside the simulation"
"""What no certificate proves."""


@dataclass(frozen=True)
class Proof:
    """The file of a log, the log, and its certificate (None if the user ended the check)."""

    path: Path
    log: Log
    certificate: Certificate | None


def certificate_json(proof: Proof) -> dict[str, Any]:
    """Return a certificate as the documented JSON object."""
    log, certificate = proof.log, proof.certificate
    if certificate is None:
        return {"verdict": None, "interrupted": True, "log_sha256": log.sha256}
    return {
        "verdict": certificate.verdict,
        "confirmed": certificate.confirmed,
        "agrees": certificate.agrees,
        "interrupted": bool(log.about.setting.get("interrupted")),
        "log_sha256": log.sha256,
        "scenario": log.about.scenario,
        "robot": log.about.robot,
        "versions": log.about.versions,
        "setting": log.about.setting,
        "claimed": log.about.claims.completed,
        "completed": certificate.completed,
        "task_costs": dict(certificate.task_costs),
        "preference": certificate.preference,
        "checks": [asdict(check) for check in certificate.checks],
    }


def in_a_line(certificate: Certificate) -> str:
    """Return the verdict of a certificate, in one line."""
    if certificate.refuted:
        first, *others = certificate.refuted
        more = f" (and {len(others)} more)" if others else ""
        return f"refuted: {first.name}: {first.words}{more}"
    found = "".join(f"; {check.name}: {check.words}" for check in certificate.findings)
    how = "simulated again from the log" if certificate.verdict == "proved" else MEANING["consistent"]
    return f"{certificate.verdict}: {how} ({len(certificate.checks)} checks){found}"


def show_certificate(console: Console, log: Log, certificate: Certificate, *, given: str | None) -> None:
    """Print a certificate, one line for each check; consecutive actions as predicted share a line.

    `given` is the name of the verifier's scenario; None if it is the one that the log describes.
    """
    claims = log.about.claims
    what = f"{given or log.about.scenario}: {'completed' if claims.completed else 'not completed'}"
    console.print(printable(f"{what}: {certificate.verdict}"), style="bold")
    for plain, checks in groupby(certificate.checks, key=_is_plain):
        row = list(checks)
        if plain and len(row) > 1:
            words = f"{len(row)} actions, the frames agree with the log"
            row = [Check(f"{row[0].name} to {row[-1].name.split()[1]}", True, words)]
        for check in row:
            mark, style = ("!!", "yellow") if check.finding else ("ok", "green") if check.holds else ("NO", "red")
            console.print(Text.assemble("  ", (mark, style), printable(f"  {check.name}: {check.words}")))
    if not certificate.confirmed:
        return
    notes = [f"{certificate.verdict}: {MEANING[certificate.verdict]}"]
    if given is None:
        notes.append("not proved: that the log is of your scenario; --scenario FILE simulates it there")
    notes.append(f"never proved: {OPEN}")
    for note in notes:
        console.print(f"  {note}", style="dim")


def _is_plain(check: Check) -> bool:
    number = check.name.removeprefix("action ")
    return check.holds and number.isdigit() and not check.words.endswith("as logged")
