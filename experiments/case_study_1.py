"""Case Study 1 of the paper: a delivery robot's five tasks, and every best trade-off of cost and desired order."""

from __future__ import annotations

from rich.table import Table

from experiments import scenarios
from experiments.console import Console
from experiments.output import condense, number
from prefplan import Front, pareto_front

SCENARIO = "case_study_1"

PUBLISHED = ((68, 29), (70, 28), (72, 24), (74, 23), (84, 11), (98, 0))
"""(cost, preference) of every point of the paper's Figure 3 (g)."""


def main() -> None:
    """Plan, and print the front beside the published one."""
    front = pareto_front(scenarios.find(SCENARIO).problem())
    console = Console(highlight=False)
    console.print(side_by_side(front))
    same = [(plan.cost, plan.preference) for plan in front] == list(PUBLISHED)
    verdict = "the published front" if same else "NOT the published front"
    console.print(f"{len(front)} points in {front.stats.seconds:.2f} s: {verdict}.")
    for i, plan in enumerate(front):
        console.print(f"\nPlan {i}\n{condense(plan.actions)}")


def side_by_side(front: Front) -> Table:
    """Return a table of the front's points, cheapest first, beside the published ones."""
    table = Table(title="Case Study 1", title_justify="left")
    for column in ("#", "cost", "preference", "published cost", "published preference"):
        table.add_column(column, justify="right")
    for i in range(max(len(front), len(PUBLISHED))):
        found = (number(front[i].cost), number(front[i].preference)) if i < len(front) else ("-", "-")
        paper = map(str, PUBLISHED[i]) if i < len(PUBLISHED) else ("-", "-")
        table.add_row(str(i), *found, *paper)
    return table


if __name__ == "__main__":
    main()
