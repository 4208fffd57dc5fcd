"""Certificates as text and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from itertools import groupby
from typing import Any

from rich.console import Console
from rich.text import Text

from prefplan.claims import Check
from prefplan.text.printable import printable
from sim.evidence.certificate import Certificate
from sim.evidence.log import Log

LEVELS = {
    "plain": "the claims follow from the recorded states, and these obey physics as far as they show it",
    "scenario": "the log is of the given scenario",
    "resimulate": "the recorded commands lead to the recorded states",
    "key": "the file is as the owner of the key signed it",
}
"""What each level of `prefplan verify` proves."""

UNPROVEN = "that the sensor saw what the log says, or that anything happened outside the simulation"
"""What no level proves."""


def certificate_json(log: Log, certificate: Certificate, levels: Sequence[str] = ("plain",)) -> dict[str, Any]:
    """Return a certificate as the documented JSON object; the levels are those of `LEVELS` that were checked."""
    return {
        "confirmed": certificate.confirmed,
        "agrees": certificate.agrees,
        "scenario": log.about.scenario,
        "levels": list(levels),
        "proves": [LEVELS[level] for level in levels] if certificate.confirmed else [],
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
    found = "".join(f"; {check.name}: {check.words}" for check in certificate.findings)
    return f"certified by an independent check of the log ({len(certificate.checks)} points){found}"


def show_certificate(console: Console, log: Log, certificate: Certificate, levels: Sequence[str]) -> None:
    """Print a certificate, one line for each check; consecutive actions as predicted share a line."""
    claims = log.about.claims
    what = f"{log.about.scenario}: {'completed' if claims.completed else 'not completed'}"
    verdict = "confirmed" if certificate.confirmed else "refuted"
    console.print(Text(printable(f"{what}: {verdict}"), style="bold"))
    for plain, checks in groupby(certificate.checks, key=_is_plain):
        row = list(checks)
        if plain and len(row) > 1:
            words = f"{len(row)} actions, the frames agree with the log"
            row = [Check(f"{row[0].name} to {row[-1].name.split()[1]}", True, words)]
        for check in row:
            mark, style = ("!!", "yellow") if check.finding else ("ok", "green") if check.holds else ("NO", "red")
            console.print(Text.assemble("  ", (mark, style), printable(f"  {check.name}: {check.words}")))
    if certificate.confirmed:
        console.print(Text(f"  proved: {'; '.join(LEVELS[level] for level in levels)}", style="dim"))
        for level in (level for level in LEVELS if level not in levels):
            console.print(Text(f"  not checked (--{level}): {LEVELS[level]}", style="dim"))
        console.print(Text(f"  never proved: {UNPROVEN}", style="dim"))


def _is_plain(check: Check) -> bool:
    number = check.name.removeprefix("action ")
    return check.holds and number.isdigit() and not check.words.endswith("as logged")
