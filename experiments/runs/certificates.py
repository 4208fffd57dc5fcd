"""Certificates for people and as JSON for programs."""

from __future__ import annotations

from dataclasses import asdict
from itertools import groupby
from typing import Any

from rich.console import Console
from rich.text import Text

from prefplan.claims import Check
from sim.evidence.certificate import Certificate
from sim.evidence.log import Log


def certificate_json(log: Log, certificate: Certificate) -> dict[str, Any]:
    """Return a certificate as the documented JSON object."""
    return {
        "confirmed": certificate.confirmed,
        "agrees": certificate.agrees,
        "scenario": log.about.scenario,
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
        return f"not certified: {first.name}: {first.words}{more}"
    return f"certified: {len(certificate.checks)} checks of its log hold"


def show_certificate(console: Console, log: Log, certificate: Certificate) -> None:
    """Print a certificate, one line for each check and one for several actions that succeeded."""
    claims = log.about.claims
    what = f"{log.about.scenario}: {'completed' if claims.completed else 'not completed'}"
    verdict = "confirmed" if certificate.confirmed else "refuted"
    console.print(Text(f"{what}: {verdict}", style="bold"))
    for plain, checks in groupby(certificate.checks, key=_is_plain):
        row = list(checks)
        if plain and len(row) > 1:
            words = f"{len(row)} actions, the frames agree with the log"
            row = [Check(f"{row[0].name} to {row[-1].name.split()[1]}", True, words)]
        for check in row:
            mark, style = ("ok", "green") if check.holds else ("NO", "red")
            console.print(Text.assemble("  ", (mark, style), f"  {check.name}: {check.words}"))


def _is_plain(check: Check) -> bool:
    number = check.name.removeprefix("action ")
    return check.holds and number.isdigit() and not check.words.endswith("as logged")
