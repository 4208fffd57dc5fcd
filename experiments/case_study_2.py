"""Case Study 2 of the paper: two tasks contradict each other, so that they are relaxed for a price.

Compares the front with Figure 4's captions, prints what each plan relaxes, and draws the figure.
"""

import sys
from pathlib import Path

import prefplan as pp
from experiments.paper.study import ERRATUM, Study, show_alone
from experiments.regression.front_comparison import compare

TITLE = "Case Study 2"
ABOUT = "The same town, but two tasks contradict each other, so that they are relaxed for a price."

PUBLISHED = ((50, 77), (60, 30), (64, 15))
"""(cost, mu) in the captions of Figure 4 (a) to (c)."""

WITH_SKIP_IN_TEXT = ((50, 67), (60, 30), (64, 15))
"""The front with the price of skipping phi5 that the text gives."""


def reproduce(study: Study, out: Path) -> None:
    """Plan, compare with Figure 4, find which price of skipping phi5 the figure has, and draw it into a folder."""
    scenario = pp.load("case_study_2")
    problem = scenario.problem()

    # phi1 needs cheese before pizza, phi5 pizza before cheese: no plan satisfies both as they are.
    strict = [pp.Task(task.name, task.formula) for task in problem.tasks]
    study.texts.append(f"As they are: {pp.pareto_front(pp.Problem(problem.system, strict, pp.Order())).reason}")

    # Relaxed for a price (Remarks 1 to 6); mu is the weighted sum of the prices paid.
    front, in_text = pp.pareto_front(problem), pp.pareto_front("case_study_2_skip20")
    study.compare_front("Figure 4", PUBLISHED, front)
    study.compare(
        "price of skipping phi5",
        "20 in the text",
        "25 in the figure",
        agrees=all(row.same for row in (*compare(PUBLISHED, front), *compare(WITH_SKIP_IN_TEXT, in_text))),
        verdict=ERRATUM,
        remark="mu of Figure 4 (a) is 77 = 2 * 25 + 15 + 12; with the text's 20 it would be 67, all else the same",
    )
    study.draw(scenario, front, out / "figure_4.svg")


if __name__ == "__main__":
    sys.exit(show_alone(Study(TITLE, ABOUT), reproduce))
