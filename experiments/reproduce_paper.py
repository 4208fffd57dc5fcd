"""The paper's examples, case studies and benchmark, computed again, and all values beside the paper's on one page."""

import sys
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from pathlib import Path

import click

import prefplan as pp
from experiments import case_study_1, case_study_2
from experiments.cli.command import call, command
from experiments.cli.console import Console
from experiments.cli.files import make_folder
from experiments.cli.start import load_planner
from experiments.cli.status import DONE, say
from experiments.cli.values import PATH
from experiments.paper import arm
from experiments.paper.study import ERRATUM, Study, write_page
from experiments.paper.table import compare_times
from prefplan.logic.good_prefix import is_satisfied
from prefplan.text.layout import condense, number

PRINTED_PLAN = "EEWNNW"
"""The satisfying plan as Example 2 prints it."""

DRAWN_PLAN = "EEWNNE"
"""The satisfying plan as the red arrows in Figure 1 show it."""

EXAMPLE_3 = ((20, 5, 10), 15)
"""A preference cost set and its mu."""

FIGURE_5 = {"cost-optimal": 0, "preference-optimal": -1}
"""The plans of Figure 5, by their index on the front."""

DIFFERENT = 1
"""Exit status when a result differs from the paper."""


@command
@click.option("--out", type=PATH, default="out/paper", metavar="DIR", help="Folder for the page (default: out/paper).")
@click.option("--quick", is_flag=True, help="Plan Case Study 3, but do not simulate it.")
def reproduce(out: Path, quick: bool) -> int:
    """Reproduce the paper's examples, case studies and benchmark, and compare all values with the paper's on one page.

    The exit status is 0 if everything agrees (except for errata of the paper, marked as such), 1 if something differs
    or could not be completed, 2 for a wrong call and 130 after Ctrl-C.
    """
    load_planner()
    make_folder(out)
    console = Console()
    studies: list[tuple[Study, Callable[[Study, Path], None]]] = [
        # Examples 1 to 3: a plan that satisfies three tasks, and the value of a preference function.
        (Study("Examples 1 to 3", "A robot on a 3 x 3 grid collects dirt, a plant and a rock, and charges."), examples),
        # Case Study 1: the Pareto front of five tasks, preferred in an order (Figure 3).
        (Study(case_study_1.TITLE, case_study_1.ABOUT), case_study_1.reproduce),
        # Case Study 2: contradicting tasks, relaxed for a price (Figure 4).
        (Study(case_study_2.TITLE, case_study_2.ABOUT), case_study_2.reproduce),
        # Case Study 3: a robot arm carries out both ends of the front (Figure 5).
        (Study(arm.TITLE, arm.ABOUT), partial(case_study_3, simulate=not quick)),
        # Table I: planning time without and with the heuristic; `python -m experiments.benchmark table1` measures it.
        (Study("Table I", "Planning time without and with the heuristic."), compare_times),
    ]
    for study, script in studies:
        study.fill(script, out, console)
    page, reproduced = out / "index.html", sum(study.reproduced for study, _ in studies)
    write_page([study for study, _ in studies], page)
    say(f"\n{reproduced} of {len(studies)} reproduced: {page}")
    return DONE if reproduced == len(studies) else DIFFERENT


def main(arguments: Sequence[str] | None = None) -> int:
    """Carry the command out and return its exit status."""
    return call(reproduce, "python experiments/reproduce_paper.py", arguments)


def examples(study: Study, out: Path) -> None:
    """Check the plans of Example 2 with the logic alone, and the preference function of Example 3."""
    scenario = pp.load("example")
    problem = scenario.problem()

    # A plan gives a trace of labels; a task is satisfied if the trace is a good prefix of its formula.
    printed, drawn = (unsatisfied_tasks(problem, plan) for plan in (PRINTED_PLAN, DRAWN_PLAN))
    study.compare("Example 2, plan drawn in Figure 1", "satisfies all tasks", _verdict(drawn), agrees=not drawn)
    study.compare(
        "Example 2, plan in the text",
        "satisfies all tasks",
        _verdict(printed),
        agrees=bool(printed) and not drawn,
        verdict=ERRATUM,
        remark="the text ends with West, which misses the charger; the figure shows East",
    )

    # The preference function of Example 3 maps task costs to mu.
    costs, mu = EXAMPLE_3
    order = pp.Problem(problem.system, problem.tasks, pp.Order()).measure
    value = order.value([Fraction(cost) for cost in costs], [Fraction(0)] * len(costs))
    study.compare(f"Example 3, mu of {costs}", str(mu), f"{float(value):g}", agrees=value == mu)

    study.draw(scenario, pp.pareto_front(problem), out / "figure_1.svg")


def unsatisfied_tasks(problem: pp.Problem, plan: str) -> list[str]:
    """Return the names of the tasks that a plan, given by its actions, does not satisfy."""
    _, _, trace, _ = problem.system.trajectory(plan)
    return [task.name for task in problem.tasks if not is_satisfied(task.tree, trace)]


def _verdict(unsatisfied: list[str]) -> str:
    return f"misses {', '.join(unsatisfied)}" if unsatisfied else "satisfies all tasks"


def case_study_3(study: Study, out: Path, *, simulate: bool) -> None:
    """Compare the model and both ends of the front with the text; if asked, carry both plans out and draw Figure 5."""
    scenario = pp.load("case_study_3")
    front = pp.pareto_front(scenario.problem())
    arm.compare_plans(study, scenario, front)
    for name, index in FIGURE_5.items():
        plan = front[index]
        values = f"cost {number(plan.cost)}, mu {number(plan.preference)}"
        study.texts.append(f"{name}: {values}: {condense([*map(plan.display.action, plan.actions)])}")
    if not simulate:
        return

    # MuJoCo takes a second to load.
    from experiments.runs.run_plan import run_plan, scene_of
    from sim.errors import RenderingError

    scene = scene_of(scenario)
    outcomes = {name: run_plan(scenario, scene, front[index]) for name, index in FIGURE_5.items()}
    for name, outcome in outcomes.items():
        rollout = outcome.run
        done = "carried out in simulation" if rollout.completed else f"stopped {rollout.reason}"
        study.compare(f"Figure 5, {name} plan", "carried out by the robot", done, agrees=rollout.completed)

    figure = out / "figure_5.png"
    try:
        arm.draw_releases(scene, outcomes, figure)
    except RenderingError as error:
        study.texts.append(f"No figure: {error}")
    else:
        caption = "the moments at which a block is put down, in the cheapest and in the preferred plan"
        study.figures.append((figure, caption))


if __name__ == "__main__":
    sys.exit(main())
