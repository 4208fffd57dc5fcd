"""What the page knows: the front, every plan, its timeline, its explanation and its run, as one JSON object."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from experiments.cli.output import number, plan_json
from experiments.report.differences import landmarks
from experiments.report.explanations import Explanation, Told, explain, explain_cheapest, titles
from experiments.report.formula_words import words_of
from experiments.report.plan_checks import check_plan
from experiments.report.timeline import Timeline, plan_timeline, timeline
from experiments.report.wishes import wishes
from prefplan.front import Front, Plan
from prefplan.models.grid import GridModel
from prefplan.problem import Task
from prefplan.scenario.decode import Scenario

if TYPE_CHECKING:
    from experiments.report.recordings import Recording

MOVE_TIME = 0.25
"""How long a move on a grid takes on the page, s."""

PAIRS = 20
"""Up to so many plans each is compared with every cheaper one; of more, with its neighbour and the cheapest."""

ACTION_TIME = 1.0
"""How long any other action takes on the page where no run says it, s."""


def page_data(scenario: Scenario, front: Front, recordings: Mapping[int, Recording]) -> dict[str, Any]:
    """Return the page's data, JSON-ready.

    Args:
        scenario: what was planned.
        front: its front.
        recordings: of some of the plans, by their number on the front.
    """
    problem = scenario.problem()
    named = titles(scenario)
    told = [
        Told(plan, plan_timeline(problem, plan), "the cheapest" if i == 0 else f"plan {i}")
        for i, plan in enumerate(front)
    ]
    return {
        "scenario": scenario.name,
        "map": {"size": list(scenario.model.size)} if isinstance(scenario.model, GridModel) else None,
        "tasks": [
            _task(task, named[task.name], automaton.accepting, automaton.dead)
            for task, automaton in zip(problem.tasks, problem.automata, strict=True)
        ],
        "plans": [_plan(scenario, told, i, recordings.get(i), _rank(front, i)) for i in range(len(told))],
    }


def _rank(front: Front, i: int) -> str | None:
    """Return what a point of a front is, if it lies at an end; the far end of an unfinished front is not known."""
    if len(front) == 1:
        return "the best in both" if front.complete else None
    if i == len(front) - 1 and front.complete:
        return "the preferred plan"
    return None if i else "the cheapest plan"


def _plan(
    scenario: Scenario, told: Sequence[Told], i: int, recording: Recording | None, rank: str | None
) -> dict[str, Any]:
    problem, (plan, planned) = scenario.problem(), (told[i].plan, told[i].timeline)
    shown, run = planned, None
    pause = MOVE_TIME if isinstance(scenario.model, GridModel) else ACTION_TIME
    times = [(k * pause, (k + 1) * pause) for k in range(len(plan.actions))]
    if recording is not None:
        shown = _observed(scenario, planned, recording)
        begin = float(recording.log.times[0])
        times = [(a.start - begin, a.end - begin) for a in recording.log.about.actions]
        run = _run(recording, plan)
    cheaper = range(i) if len(told) <= PAIRS else sorted({i - 1, 0} - {i, -1})
    explained = {j: explain(scenario, told[i], told[j]) for j in cheaper}
    checks = [
        {"name": check.name, "holds": check.holds, "words": check.words} for check in check_plan(problem, plan, planned)
    ]
    return {
        "index": i,
        **plan_json(plan),
        "rank": rank,
        "explanations": [_explanation(one, j) for j, one in explained.items()]
        or [_explanation(explain_cheapest(scenario, told[0]), None)],
        "wishes": [
            {"task": wish.task, "words": wish.words, "adds": wish.adds} for wish in wishes(scenario.preference, plan)
        ],
        "order": list(planned.order),
        "timeline": _timeline(shown),
        "times": [[round(start, 3), round(end, 3)] for start, end in times],
        "map_words": _map_words(scenario, plan, planned),
        "checks": checks,
        "run": run,
    }


def _explanation(explanation: Explanation, against: int | None) -> dict[str, Any]:
    return {"against": against, "headline": explanation.headline, "details": list(explanation.details)}


def _timeline(shown: Timeline) -> dict[str, Any]:
    return {
        "actions": list(shown.actions),
        "costs": [number(cost) for cost in shown.costs],
        "spent": list(shown.spent),
        "tracks": {
            name: {
                "states": None if track.states is None else list(track.states),
                "satisfied": track.satisfied,
                "advances": list(track.advances),
                "bought": [{"step": b.step, "assume": b.assume, "cost": number(b.cost)} for b in track.bought],
            }
            for name, track in shown.tracks.items()
        },
    }


def _observed(scenario: Scenario, planned: Timeline, recording: Recording) -> Timeline:
    """Return what a run came to."""
    about = recording.log.about
    labels = [planned.labels[0], *(frozenset(action.label) for action in about.actions)]
    return timeline(
        scenario.problem(),
        [action.action for action in about.actions],
        [action.cost for action in about.actions],
        labels,
        about.claims.relaxations,
    )


def _run(recording: Recording, plan: Plan) -> dict[str, Any]:
    outcome = recording.outcome
    return {
        "video": recording.video.name if recording.video else None,
        "no_video": recording.no_video,
        "log": recording.log_path.name,
        "completed": outcome["completed"],
        "reason": outcome.get("reason"),
        "as_planned": outcome["executed"] == list(plan.actions),
        "replans": outcome["replans"],
        "seconds": outcome["sim_seconds"],
        "placement_error_mm": outcome["max_placement_error_mm"],
        "certificate": recording.certificate,
    }


def _map_words(scenario: Scenario, plan: Plan, planned: Timeline) -> str | None:
    """Return what a plan's map shows, for those who cannot see it."""
    if not isinstance(scenario.model, GridModel):
        return None
    width, height = scenario.model.size
    way = ", ".join(landmarks(scenario.problem(), planned)) or "no region that a task asks for"
    moves = "1 move" if len(plan.actions) == 1 else f"{len(plan.actions)} moves"
    return f"Map of {width} by {height} cells with the robot's path of {moves}, by way of {way}."


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
