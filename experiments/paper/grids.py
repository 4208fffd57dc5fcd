"""Examples 1 to 3 and Case Studies 1 and 2 of the paper: robots on grids."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

from experiments import scenarios
from experiments.case_study_1 import PUBLISHED as FIGURE_3
from experiments.case_study_2 import PUBLISHED as FIGURE_4
from experiments.cli.output import condense, relaxed
from experiments.figures import plans
from experiments.paper.findings import Finding, Study, compared, erratum, fact, point_by_point
from experiments.regression.front_comparison import compare
from prefplan import Front, Order, Problem, Scenario, pareto_front, parse
from prefplan.logic.good_prefix import is_satisfied

WITH_20 = ((50, 67), (60, 30), (64, 15))
"""What the price in the text gives in place of Figure 4's."""

PRINTED_PLAN, DRAWN_PLAN = "EEWNNW", "EEWNNE"
"""The satisfying plan as Example 2 prints it, and as the red arrows in Figure 1 show it."""

EXAMPLE_3 = ((Fraction(20), Fraction(5), Fraction(10)), 15)
"""A preference cost set and its mu."""


def examples(out: Path) -> Study:
    """Return Examples 1 to 3, with a map of the plans in a folder."""
    scenario = scenarios.find("example")
    problem = scenario.problem()
    front = pareto_front(problem)
    printed, drawn = (_unsatisfied(problem, plan) for plan in (PRINTED_PLAN, DRAWN_PLAN))
    costs, mu = EXAMPLE_3
    ours = Problem(problem.system, problem.tasks, Order()).measure.value(
        [Fraction(cost) for cost in costs], [Fraction(0)] * 3
    )
    findings = [
        fact("Example 2, plan drawn in Figure 1", "satisfies all tasks", _verdict(drawn), not drawn),
        erratum(
            "Example 2, plan in the text",
            "satisfies all tasks",
            _verdict(printed),
            bool(printed) and not drawn,
            remark="the text ends with West, which misses the charger; the figure shows East",
        ),
        compared(f"Example 3, mu of ({', '.join(map(str, costs))})", str(mu), f"{float(ours):g}"),
    ]
    about = "A robot on a 3 x 3 grid collects dirt, a plant and a rock, and charges."
    return _study("Examples 1 to 3", about, scenario, front, findings, out / "figure_1.svg")


def case_study_1(out: Path) -> Study:
    """Return Case Study 1, with Figure 3 in a folder."""
    scenario = scenarios.find("case_study_1")
    front = pareto_front(scenario.problem())
    about = "A delivery robot's five tasks, preferred in the order of the customers."
    findings = point_by_point("Figure 3", FIGURE_3, front)
    return _study("Case Study 1", about, scenario, front, findings, out / "figure_3.svg")


def case_study_2(out: Path) -> Study:
    """Return Case Study 2, with Figure 4 in a folder."""
    scenario = scenarios.find("case_study_2")
    front = pareto_front(scenario.problem())
    with_20 = pareto_front(scenarios.find("case_study_2_skip20").problem())
    findings = point_by_point("Figure 4", FIGURE_4, front)
    findings.append(
        erratum(
            "price of skipping phi5",
            "20 in the text",
            "25 in the figure",
            all(row.same for row in (*compare(FIGURE_4, front), *compare(WITH_20, with_20))),
            remark="mu of Figure 4 (a) is 77 = 2 * 25 + 15 + 12; with the text's 20 it would be 67, all else the same",
        )
    )
    about = "The same town, but two tasks contradict each other, so that some are relaxed for a price."
    return _study("Case Study 2", about, scenario, front, findings, out / "figure_4.svg")


def _study(title: str, about: str, scenario: Scenario, front: Front, findings: list[Finding], figure: Path) -> Study:
    plans.draw(scenario, front, figure)
    lines = []
    for i, plan in enumerate(front):
        lines += [f"Plan {i}: {condense(plan.actions)}", *relaxed(plan)]
    shows = "every plan of the front, and the front"
    return Study(title, about, tuple(findings), ((figure, shows),), tuple(lines))


def _unsatisfied(problem: Problem, plan: str) -> list[str]:
    """Return the tasks that a plan leaves unsatisfied, by name."""
    state = problem.system.start
    trace = [problem.system.label(state)]
    for action in plan:
        state, _ = problem.system.step(state, action)
        trace.append(problem.system.label(state))
    return [task.name for task in problem.tasks if not is_satisfied(parse(task.formula), trace)]


def _verdict(unsatisfied: list[str]) -> str:
    return f"misses {', '.join(unsatisfied)}" if unsatisfied else "satisfies all tasks"
