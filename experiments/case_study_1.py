"""Case Study 1 of the paper: a delivery robot's five tasks, and every best trade-off of cost and desired order.

Plans from Python, prints the front beside Figure 3's captions and every plan, and draws the figure again.
"""

from __future__ import annotations

import sys
from pathlib import Path

import prefplan as pp
from experiments.cli.files import make_folder
from experiments.figures import plans
from prefplan.text.layout import condense

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


def main() -> int:
    """Plan, compare, draw; return 1 if the front is not the published one."""
    # What the robot can do: a weighted transition system (Definition 1).
    town = pp.GridModel(SIZE, START, regions=TOWN)

    # The tasks, preferred in this order (Example 3): mu is how long they are delayed against it.
    problem = pp.Problem(town.transition_system(), TASKS, pp.Order())

    # Every plan for which no other is both cheaper and preferred (Problem 1).
    front = pp.pareto_front(problem)

    for plan, published in zip(front, PUBLISHED, strict=False):
        verdict = "agrees" if (plan.cost, plan.preference) == published else "DIFFERS"
        print(f"cost {plan.cost}, mu {plan.preference:2}; the paper: {published}, {verdict}")
        print(f"    {condense(plan.actions)}")

    figure = OUT / "figure_3.svg"
    make_folder(OUT)
    plans.draw(pp.Scenario("case_study_1", Path(), town, TASKS, pp.Order()), front, figure)
    print(figure)
    return 0 if [(plan.cost, plan.preference) for plan in front] == list(PUBLISHED) else 1


if __name__ == "__main__":
    sys.exit(main())
