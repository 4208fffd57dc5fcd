"""Case Study 1 of the paper: a delivery robot's five tasks, and every best trade-off of cost and desired order.

Plans from Python, compares the front with Figure 3's captions, prints every plan, and draws the figure again.
"""

from __future__ import annotations

import sys
from pathlib import Path

import prefplan as pp
from experiments.cli.files import make_folder
from experiments.paper.study import Study, show_alone

TITLE, ABOUT = "Case Study 1", "A delivery robot's five tasks, preferred in the order of the customers."

SIZE, START = (20, 20), (0, 0)
"""Cells, of unit cost."""

TOWN = {
    "p1": [(2, 0, 4, 2)],
    "p2": [(7, 2, 9, 4)],
    "tacos": [(12, 1, 18, 5)],
    "cheese": [(17, 7, 19, 9)],
    "p3": [(17, 11, 19, 15)],
    "p4": [(16, 17, 18, 19)],
    "grocer": [(10, 10, 14, 19)],
    "pizza": [(0, 15, 6, 18)],
}
"""Boxes x0, y0, x1, y1, corners inclusive."""

TASKS = (
    pp.Task("phi1", "!pizza U cheese"),
    pp.Task("phi2", "F(grocer & F(p2))"),
    pp.Task("phi3", "F(tacos & F(p3) & F(p4))"),
    pp.Task("phi4", "F(pizza & F(p1))"),
    pp.Task("phi5", "F(cheese & F(tacos) & F(grocer) & F(pizza))"),
)

PUBLISHED = ((68, 29), (70, 28), (72, 24), (74, 23), (84, 11), (98, 0))
"""(cost, mu) in the captions of Figure 3 (a) to (f)."""

OUT = Path("out", "case_study_1")
"""Where the figure goes."""


def reproduce(study: Study, out: Path) -> None:
    """Plan, compare with Figure 3, and draw the figure into a folder."""
    # What the robot can do: a weighted transition system (Definition 1).
    town = pp.GridModel(SIZE, START, regions=TOWN)

    # The tasks, preferred in this order (Example 3): mu is how long they are delayed against it.
    problem = pp.Problem(town.transition_system(), TASKS, pp.Order())

    # Every plan for which no other is both cheaper and preferred (Problem 1).
    front = pp.pareto_front(problem)

    study.compare_front("Figure 3", PUBLISHED, front)
    make_folder(out)
    study.draw(pp.Scenario("case_study_1", Path(), town, TASKS, pp.Order()), front, out / "figure_3.svg")


def main() -> int:
    """Carry the study out; return 1 if the front is not the published one."""
    study = Study(TITLE, ABOUT)
    reproduce(study, OUT)
    return show_alone(study)


if __name__ == "__main__":
    sys.exit(main())
