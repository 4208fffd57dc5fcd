"""Case Study 2 of the paper: two tasks contradict each other, so that they are relaxed for a price.

Plans from Python, compares the front with Figure 4's captions, prints what each plan relaxes, and draws the figure.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import prefplan as pp
from experiments.case_study_1 import SIZE, START, TOWN
from experiments.cli.files import make_folder
from experiments.paper.study import Study, show_alone
from experiments.regression.front_comparison import compare

TITLE = "Case Study 2"
ABOUT = "The same town, but two tasks contradict each other, so that they are relaxed for a price."

SKIP_PHI5, SKIP_IN_TEXT = 25, 20
"""Price of skipping phi5 in the figure and in the text, which contradict each other."""

TASKS = (
    pp.Task("phi1", "!pizza U cheese", (pp.Relaxation("cheese", when="grocer", cost=15),)),
    pp.Task("phi2", "F(grocer & F(p2))"),
    pp.Task("phi3", "F(tacos & F(p3) & F(p4))", (pp.Relaxation("p4", when="true", cost=15),)),
    pp.Task("phi4", "F(pizza & F(p1))", (pp.Relaxation("pizza", when="tacos", cost=12),)),
    pp.Task("phi5", "(!cheese U pizza) & (!cheese U tacos)", skip=SKIP_PHI5),
)

WEIGHTS = {"phi1": 1, "phi2": 1, "phi3": 1, "phi4": 1, "phi5": 2}
"""Weight of the price paid to relax each task."""

PUBLISHED = ((50, 77), (60, 30), (64, 15))
"""(cost, mu) in the captions of Figure 4 (a) to (c)."""

WITH_SKIP_IN_TEXT = ((50, 67), (60, 30), (64, 15))
"""The front with the price in the text."""

OUT = Path("out", "case_study_2")
"""Where the figure goes."""


def reproduce(study: Study, out: Path) -> None:
    """Plan, compare with Figure 4, find which price of skipping phi5 the figure has, and draw it into a folder."""
    # phi1 needs cheese before pizza, phi5 pizza before cheese: no plan satisfies both as they are.
    town = pp.GridModel(SIZE, START, regions=TOWN)
    strict = [pp.Task(task.name, task.formula) for task in TASKS]
    study.texts.append(f"As they are: {pp.pareto_front(pp.Problem(town, strict, pp.Order())).reason}")

    # Relaxed for a price (Remarks 1 to 6); mu is the weighted sum of the prices paid.
    preference = pp.WeightedSum(WEIGHTS, over="violation")

    def front_of(tasks: Sequence[pp.Task]) -> pp.Front:
        return pp.pareto_front(pp.Problem(town, tasks, preference))

    front, in_text = front_of(TASKS), front_of([*TASKS[:-1], replace(TASKS[-1], skip=SKIP_IN_TEXT)])
    study.compare_front("Figure 4", PUBLISHED, front)
    study.erratum(
        "price of skipping phi5",
        f"{SKIP_IN_TEXT} in the text",
        f"{SKIP_PHI5} in the figure",
        confirmed=all(row.same for row in (*compare(PUBLISHED, front), *compare(WITH_SKIP_IN_TEXT, in_text))),
        remark="mu of Figure 4 (a) is 77 = 2 * 25 + 15 + 12; with the text's 20 it would be 67, all else the same",
    )
    make_folder(out)
    study.draw(pp.Scenario("case_study_2", Path(), town, TASKS, preference), front, out / "figure_4.svg")


def main() -> int:
    """Carry the study out; return 1 if the front is not the published one."""
    study = Study(TITLE, ABOUT)
    reproduce(study, OUT)
    return show_alone(study)


if __name__ == "__main__":
    sys.exit(main())
