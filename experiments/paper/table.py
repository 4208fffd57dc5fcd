"""Table I of the paper: planning times without and with the heuristic."""

import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from statistics import median

from experiments.benchmark.instances import RANDOM, known
from experiments.benchmark.plot import TITLES
from experiments.benchmark.published import PUBLISHED
from experiments.benchmark.runs import BARE, FRONT, KINDS, MAX_MIN, SINGLE, wrong_fronts
from experiments.benchmark.summary import cells, table
from experiments.paper.study import ERRATUM, MEASURED, Study

RESULTS = Path(__file__).parents[1] / "results"
"""The results that ship."""

ORDER_OF_MAGNITUDE = 10

Times = Mapping[tuple[str, str, int], float]
"""Median seconds by kind of search, method and number of tasks."""


def compare_times(study: Study, out: Path) -> None:
    """Add the times from the results of `experiments.benchmark` that ship; their picture is copied to a folder."""
    lines = (RESULTS / "table1.jsonl").read_text(encoding="utf-8").splitlines()
    machine, *records = map(json.loads, lines)
    study.about = (
        f"Tasks F(a & F(b) & F(c)) on a 10 x 10 grid; medians on {machine['cpu']}, {machine['cores']} cores, Python "
        f"{machine['python']}. The paper's times are those of its C++ on its machine; the yardstick is its method in "
        "our kernels."
    )
    wrong = wrong_fronts()
    study.compare(
        f"fronts of {len(list(known()))} instances like the paper's",
        "-",
        f"{len(wrong)} are wrong" if wrong else "as an independent exact solver has them",
        agrees=not wrong,
        remark="; ".join(wrong),
    )
    found = cells(record for record in records if record["family"] == RANDOM)
    times = {
        (cell.what["kind"], cell.what["method"], cell.what["tasks"]): median(
            record["seconds"] for record in cell.runs.values()
        )
        for cell in found
    }
    _growth(study, times)
    _speed_up(study, times)
    picture = out / "table_1.png"
    shutil.copyfile(RESULTS / "table1.png", picture)
    study.figures.append((picture, "seconds against the number of tasks"))
    for kind in KINDS:
        study.texts += [f"{TITLES[kind]}:", *table([cell for cell in found if cell.what["kind"] == kind]).splitlines()]


def _growth(study: Study, times: Times) -> None:
    """Add the factor by which the time with the heuristic grows with each task."""
    for kind, name in ((SINGLE, "one plan"), (FRONT, "front")):
        paper = PUBLISHED[kind, MAX_MIN]
        tasks = [n for n in paper if (kind, MAX_MIN, n) in times]
        factors = [
            (seconds[tasks[-1]] / seconds[tasks[0]]) ** (1 / (tasks[-1] - tasks[0]))
            for seconds in (paper, {n: times[kind, MAX_MIN, n] for n in tasks})
        ]
        study.compare(
            f"time of {name} with each task",
            f"x {factors[0]:.1f}, exponential",
            f"x {factors[1]:.1f} for its method in our kernels",
            verdict=MEASURED,
        )


def _speed_up(study: Study, times: Times) -> None:
    """Add the speed-up by the heuristic for the greatest number of tasks that both methods finish."""
    most = max(n for kind, method, n in times if method == BARE and kind == FRONT)
    paper = {kind: PUBLISHED[kind, BARE][most] / PUBLISHED[kind, MAX_MIN][most] for kind in (SINGLE, FRONT)}
    ours = {kind: times[kind, BARE, most] / times[kind, MAX_MIN, most] for kind in (SINGLE, FRONT)}
    study.compare(
        f"heuristic, one plan of {most} tasks",
        f"x {paper[SINGLE]:.0f} faster",
        f"x {ours[SINGLE]:.0f} faster",
        verdict=MEASURED,
    )
    study.compare(
        f"heuristic, front of {most} tasks",
        f"at least x {ORDER_OF_MAGNITUDE} faster in the text",
        f"x {ours[FRONT]:.1f} faster",
        agrees=paper[FRONT] < ORDER_OF_MAGNITUDE,
        verdict=ERRATUM,
        remark=f"the paper's own table has x {paper[FRONT]:.1f}",
    )
