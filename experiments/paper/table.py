"""Table I of the paper: how long planning takes, without and with the heuristic."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from pathlib import Path

from experiments.benchmark.facts import KNOWN, PUBLISHED
from experiments.benchmark.instances import RANDOM
from experiments.benchmark.runs import BARE, FRONT, MAX_MIN, OURS, SINGLE, wrong_fronts
from experiments.paper.findings import Finding, Study, erratum, fact, measured

RESULTS = Path(__file__).parents[1] / "results"
"""The results that ship."""

ORDER_OF_MAGNITUDE = 10

Times = Mapping[tuple[str, str, int], float]
"""Median seconds by what is planned, method and number of tasks."""


def table_1(out: Path, results: Path = RESULTS) -> Study:
    """Return Table I from results of `experiments.benchmark.table1`, with their picture in a folder."""
    report = json.loads((results / "table1.json").read_text(encoding="utf-8"))
    times = {
        (cell["kind"], cell["method"], cell["tasks"]): cell["seconds"]["median"]
        for cell in report["cells"]
        if cell["family"] == RANDOM
    }
    wrong = wrong_fronts()
    findings = [
        fact(
            f"fronts of {len(KNOWN)} instances like its own",
            "-",
            "as an independent exact solver has them" if not wrong else f"{len(wrong)} are wrong",
            not wrong,
            remark="; ".join(wrong),
        ),
        *_growth(times),
        *_speed_up(times),
    ]
    picture = out / "table_1.png"
    shutil.copyfile(results / "table1.png", picture)
    machine = report["machine"]
    about = (
        f"Tasks F(a & F(b) & F(c)) on a 10 x 10 grid; medians of {report['date']}, {machine['cpu']}, "
        f"{machine['cores']} cores. The paper's times are those of its C++ on its machine; the yardstick is its method "
        "in our kernels."
    )
    return Study("Table I", about, tuple(findings), ((picture, "seconds against the number of tasks"),), _rows(times))


def _growth(times: Times) -> list[Finding]:
    """Return how planning time grows with each task, with the heuristic."""
    findings = []
    for kind, name in ((SINGLE, "one plan"), (FRONT, "front")):
        paper = PUBLISHED[kind, MAX_MIN]
        tasks = [n for n in paper if (kind, MAX_MIN, n) in times]
        factors = [
            (seconds[tasks[-1]] / seconds[tasks[0]]) ** (1 / (tasks[-1] - tasks[0]))
            for seconds in (paper, {n: times[kind, MAX_MIN, n] for n in tasks})
        ]
        findings.append(
            measured(
                f"time of {name} with each task",
                f"x {factors[0]:.1f}, exponential",
                f"x {factors[1]:.1f} for its method in our kernels",
            )
        )
    return findings


def _speed_up(times: Times) -> list[Finding]:
    """Return how much the heuristic saves at the greatest number of tasks that all methods can do."""
    most = max(n for kind, method, n in times if method == BARE and kind == FRONT)
    paper, ours = (
        {kind: of(kind, BARE) / of(kind, MAX_MIN) for kind in (SINGLE, FRONT)}
        for of in (lambda kind, method: PUBLISHED[kind, method][most], lambda kind, method: times[kind, method, most])
    )
    return [
        measured(
            f"heuristic, one plan of {most} tasks",
            f"x {paper[SINGLE]:.0f} faster",
            f"x {ours[SINGLE]:.0f} faster",
        ),
        erratum(
            f"heuristic, front of {most} tasks",
            f"at least x {ORDER_OF_MAGNITUDE} faster in the text",
            f"x {ours[FRONT]:.1f} faster",
            paper[FRONT] < ORDER_OF_MAGNITUDE,
            remark=f"the paper's own table has x {paper[FRONT]:.1f}",
        ),
    ]


def _rows(times: Times) -> tuple[str, ...]:
    """Return the table as lines of text: seconds of the paper, of the yardstick and of prefplan."""
    lines = [
        f"{'':>10} {'':>3} {'paper':>18} {'yardstick':>18} {'prefplan':>9}",
        f"{'':>10} {'N':>3} {'w/o h':>9}{'w/ h':>9} {'w/o h':>9}{'w/ h':>9}",
    ]
    for kind, name in ((SINGLE, "one plan"), (FRONT, "front")):
        for n in PUBLISHED[kind, BARE]:
            paper = [PUBLISHED[kind, method][n] for method in (BARE, MAX_MIN)]
            some = [times.get((kind, method, n)) for method in (BARE, MAX_MIN, OURS)]
            cells = [f"{value:.3g}" if value is not None else "" for value in (*paper, *some)]
            lines.append(f"{name:>10} {n:>3} {cells[0]:>9}{cells[1]:>9} {cells[2]:>9}{cells[3]:>9} {cells[4]:>9}")
    return tuple(lines)
