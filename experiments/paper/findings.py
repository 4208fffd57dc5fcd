"""What a study found, fact by fact beside what the paper says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.table import Table

from experiments.cli.output import number
from experiments.regression.front_comparison import Point, compare
from prefplan.front import Front

AGREES, DIFFERS, ERRATUM, MEASURED = "agrees", "DIFFERS", "paper errs", "measured"


@dataclass(frozen=True)
class Finding:
    """A fact.

    Attributes:
        what: is compared.
        paper: what it says.
        ours: what was found.
        verdict: `AGREES`, `DIFFERS`, `ERRATUM` where the paper contradicts itself and ours is what its other
            statement gives, or `MEASURED` for times, which no two machines have in common.
        remark: what a reader should know of it.
    """

    what: str
    paper: str
    ours: str
    verdict: str
    remark: str = ""


@dataclass(frozen=True)
class Study:
    """A part of the paper, done again.

    Attributes:
        title: its name in the paper.
        about: what it is about, a sentence.
        findings: facts beside the paper's.
        figures: files with pictures, and what each shows.
        texts: lines worth reading below, such as plans.
        failure: why it could not be done; None if it was.
    """

    title: str
    about: str
    findings: tuple[Finding, ...] = ()
    figures: tuple[tuple[Path, str], ...] = ()
    texts: tuple[str, ...] = ()
    failure: str | None = None

    @property
    def reproduced(self) -> bool:
        """Whether it was done and nothing differs from what the paper says, its errors aside."""
        return self.failure is None and all(finding.verdict != DIFFERS for finding in self.findings)


def compared(what: str, paper: str, ours: str, *, remark: str = "") -> Finding:
    """Return a fact that agrees if both are the same text."""
    return Finding(what, paper, ours, AGREES if paper == ours else DIFFERS, remark)


def fact(what: str, paper: str, ours: str, holds: bool, *, remark: str = "") -> Finding:
    """Return a fact that is worded differently on both sides."""
    return Finding(what, paper, ours, AGREES if holds else DIFFERS, remark)


def erratum(what: str, paper: str, ours: str, confirmed: bool, *, remark: str) -> Finding:
    """Return a fact that the paper has wrong, if that was confirmed."""
    return Finding(what, paper, ours, ERRATUM if confirmed else DIFFERS, remark)


def measured(what: str, paper: str, ours: str) -> Finding:
    """Return a fact about time."""
    return Finding(what, paper, ours, MEASURED)


def point_by_point(figure: str, published: Sequence[Point], front: Front) -> list[Finding]:
    """Return a fact for every point of a front that is published or found; a figure has a letter for each.

    Args:
        figure: its name in the paper.
        published: points in the figure's order.
        front: what was found.
    """
    findings = []
    for row in compare(published, front):
        panel = f"{figure} ({'abcdefgh'[published.index(row.expected)]})" if row.expected else "a point too many"
        paper, ours = (f"cost {number(p[0])}, mu {number(p[1])}" if p else "-" for p in (row.expected, row.found))
        findings.append(fact(panel, paper, ours, row.same))
    return findings


def as_table(study: Study) -> Table:
    """Return a study's findings as a table, paper and ours side by side."""
    table = Table(title=study.title, title_justify="left")
    for column in ("", "paper", "ours", "verdict"):
        table.add_column(column)
    for finding in study.findings:
        table.add_row(finding.what, finding.paper, finding.ours, finding.verdict)
    return table


def remarks(study: Study) -> list[str]:
    """Return the remarks on a study's findings, one a line."""
    return [f"{finding.what}: {finding.remark}" for finding in study.findings if finding.remark]
