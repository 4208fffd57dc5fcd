"""The data of the page as one JSON object: the front, and every plan with its ledger, explanations, checks and run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from experiments.cli.output import number, plan_json
from experiments.figures.front import cost_unit
from experiments.figures.grid_map import path_of
from experiments.report.differences import landmarks
from experiments.report.explanations import Explanation, NamedPlan, explain, explain_cheapest
from experiments.report.pictures import graph_data
from experiments.report.preference_words import shares
from experiments.runs.formula_words import titles, words_of
from prefplan.claims import Check, Claims, judge
from prefplan.exact_costs import to_number
from prefplan.front import Front, Plan
from prefplan.ledger import Ledger
from prefplan.models.grid import GridModel
from prefplan.problem import Problem, Task
from prefplan.scenario.decode import Scenario

if TYPE_CHECKING:
    from experiments.report.recordings import Recording

MOVE_TIME_S = 0.25
"""Time of a move on a grid on the page."""

ACTION_TIME_S = 1.0
"""Time of any other action on the page, where no run gives it."""

MAX_PAIRED = 20
"""Of so many plans each is compared with every cheaper one; of more, with its neighbour and the cheapest."""


def page_data(scenario: Scenario, front: Front, recordings: Mapping[int, Recording]) -> dict[str, Any]:
    """Return the page's data, JSON-ready.

    Args:
        scenario: what was planned.
        front: its front.
        recordings: of some of the plans, by their number on the front.
    """
    problem = scenario.problem()
    named = titles(scenario)
    plans = [
        NamedPlan(plan, Ledger.of_plan(problem, plan), f"plan {i}" if i else "the cheapest")
        for i, plan in enumerate(front)
    ]
    return {
        "scenario": scenario.name,
        "cost_unit": cost_unit(scenario),
        "map": {"size": list(scenario.model.size)} if isinstance(scenario.model, GridModel) else None,
        "tasks": [
            _task(task, named[task.name], automaton.accepting, automaton.dead)
            for task, automaton in zip(problem.tasks, problem.automata, strict=True)
        ],
        "plans": [_plan(scenario, plans, i, recordings.get(i), _rank(front, i)) for i in range(len(plans))],
    }


def check_plan(problem: Problem, plan: Plan, ledger: Ledger) -> tuple[Check, ...]:
    """Check a plan's costs, tasks, relaxations and preference by their definitions.

    Args:
        problem: what was planned.
        plan: what the search says.
        ledger: gives the labels and the costs of the plan's actions; its automata are not used.
    """
    said = {key: plan_json(plan)[key] for key in ("cost", "preference", "task_costs", "violation_costs")}
    claims = Claims(completed=True, relaxations=plan.relaxations, **said)
    exists = Check("actions", True, f"each of the {len(plan.actions)} exists where it is taken")
    return exists, *judge(claims, problem.tasks, problem.preference, ledger.labels, ledger.costs).checks


def _rank(front: Front, i: int) -> str | None:
    """Return what a point of a front is, if it lies at an end; the far end of an unfinished front is not known."""
    if len(front) == 1:
        return "the best in both" if front.complete else None
    if i == len(front) - 1 and front.complete:
        return "the preferred plan"
    return None if i else "the cheapest plan"


def _plan(
    scenario: Scenario, plans: Sequence[NamedPlan], i: int, recording: Recording | None, rank: str | None
) -> dict[str, Any]:
    problem, (plan, planned) = scenario.problem(), (plans[i].plan, plans[i].ledger)
    shown, run = planned, None
    period = MOVE_TIME_S if isinstance(scenario.model, GridModel) else ACTION_TIME_S
    times = [(k * period, (k + 1) * period) for k in range(len(plan.actions))]
    if recording is not None:
        shown, run = _observed(problem, planned, recording), _run(recording, plan)
        begin = float(recording.log.times[0])
        times = [(action.start - begin, action.end - begin) for action in recording.log.about.actions]
    cheaper = range(i) if len(plans) <= MAX_PAIRED else sorted({i - 1, 0} - {i, -1})
    explained = [_explanation(explain(scenario, plans[i], plans[j]), j) for j in cheaper]
    return {
        "index": i,
        **plan_json(plan),
        "rank": rank,
        "explanations": explained or [_explanation(explain_cheapest(scenario, plans[0]), None)],
        "shares": [asdict(share) for share in shares(scenario.preference, plan)],
        "order": list(planned.order),
        "ledger": _ledger(shown),
        "times": [[round(start, 3), round(end, 3)] for start, end in times],
        "path": path_of(plan).states.tolist() if isinstance(scenario.model, GridModel) else None,
        "graph": graph_data(scenario, plan),
        "map_words": _map_words(scenario, planned),
        "checks": [asdict(check) for check in check_plan(problem, plan, planned)],
        "run": run,
    }


def _explanation(explanation: Explanation, against: int | None) -> dict[str, Any]:
    return {"against": against, "headline": explanation[0], "details": explanation[1]}


def _ledger(ledger: Ledger) -> dict[str, Any]:
    return {
        "actions": list(ledger.actions),
        "costs": [number(to_number(cost)) for cost in ledger.costs],
        "spent": [to_number(cost) for cost in ledger.spent],
        "tasks": {
            name: {
                "states": states and list(states),
                "satisfied": ledger.satisfied[name],
                "advances": list(ledger.advances(name)),
                "bought": [
                    {"step": bought.step, "assume": bought.assume, "cost": number(bought.cost)}
                    for bought in ledger.relaxations
                    if bought.task == name
                ],
            }
            for name, states in ledger.states.items()
        },
    }


def _observed(problem: Problem, planned: Ledger, recording: Recording) -> Ledger:
    """Return the ledger of a run."""
    about = recording.log.about
    return Ledger.of(
        problem,
        [action.action for action in about.actions],
        [action.cost for action in about.actions],
        [planned.labels[0], *(frozenset(action.label) for action in about.actions)],
        about.claims.relaxations,
    )


def _run(recording: Recording, plan: Plan) -> dict[str, Any]:
    outcome = recording.outcome
    return {
        "video": recording.video.name if recording.video else None,
        "no_video": recording.no_video,
        "begin": float(recording.log.times[0]),
        "log": recording.log_path.name,
        "completed": outcome["completed"],
        "reason": outcome.get("reason"),
        "as_planned": outcome["executed"] == list(plan.actions),
        "replans": outcome["replans"],
        "seconds": outcome["sim_seconds"],
        "placement_error_mm": outcome["max_placement_error_mm"],
        "certificate": recording.certificate,
    }


def _map_words(scenario: Scenario, planned: Ledger) -> str | None:
    """Return what a plan's map shows, for readers who cannot see it."""
    if not isinstance(scenario.model, GridModel):
        return None
    width, height = scenario.model.size
    passed = ", ".join(landmarks(planned)) or "no region of a task"
    moves = "1 move" if len(planned.actions) == 1 else f"{len(planned.actions)} moves"
    return f"Map of {width} by {height} cells with the robot's path of {moves} through {passed}."


def _task(task: Task, title: str, accepting: int | None, dead: int | None) -> dict[str, Any]:
    offers = []
    for one in task.relax:
        where = "anywhere" if one.when == "true" else f"where {one.when} holds"
        offers.append(f"{one.assume} may count as true {where}, for {number(one.cost)} each time")
    if task.skip is not None:
        offers.append(f"it may be skipped, for {number(task.skip)}")
    return {
        "name": task.name,
        "title": title,
        "formula": " ".join(task.formula.split()),
        "words": words_of(task.formula),
        "accepting": accepting,
        "dead": dead,
        "offers": offers,
    }
