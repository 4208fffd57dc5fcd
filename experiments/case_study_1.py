"""Case Study 1 of the paper: a delivery robot's five tasks, and every best trade-off of cost and desired order.

Compares the front with Figure 3's captions, prints every plan, and draws the figure again.
"""

import sys
from pathlib import Path

import prefplan as pp
from experiments.paper.study import Study, show_alone

TITLE, ABOUT = "Case Study 1", "A delivery robot's five tasks, preferred in the order of the customers."

PUBLISHED = ((68, 29), (70, 28), (72, 24), (74, 23), (84, 11), (98, 0))
"""(cost, mu) in the captions of Figure 3 (a) to (f)."""


def reproduce(study: Study, out: Path) -> None:
    """Plan, compare with Figure 3, and draw the figure into a folder."""
    # A weighted transition system (Definition 1), and tasks in the desired order (Example 3): mu is their total delay
    # against this order.
    scenario = pp.load("case_study_1")

    # Every plan for which no other is both cheaper and preferred (Problem 1).
    front = pp.pareto_front(scenario.problem())

    study.compare_front("Figure 3", PUBLISHED, front)
    study.draw(scenario, front, out / "figure_3.svg")


if __name__ == "__main__":
    sys.exit(show_alone(Study(TITLE, ABOUT), reproduce))
