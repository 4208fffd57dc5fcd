"""The data of the page as one JSON object: the front, and every plan with its ledger, explanations, checks and run."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any, cast

from experiments.cli.output import plan_json
from experiments.figures.front import cost_unit
from experiments.figures.maps import map_of
from experiments.report.explanations import Explanation, NamedPlan, explain, explain_cheapest
from experiments.report.pictures import routes
from experiments.report.preference_words import ordinal, shares
from experiments.runs.formula_words import titles, words_of
from prefplan import Front, Ledger, Plan, Preference, Problem, Rule, Scenario, Task, WeightedSum
from prefplan.claims import Check, Claims, judge
from prefplan.exact_costs import to_number
from prefplan.logic.formula import TRUE, Until
from prefplan.plan import objectives_text
from prefplan.preferences.objective import Measure
from prefplan.text.layout import number

if TYPE_CHECKING:
    from experiments.report.recordings import Recording

MOVE_TIME_S = 0.25
"""Time of a move on a grid on the page, s."""

ACTION_TIME_S = 1.0
"""Time of any other action on the page that was not carried out, s."""

MAX_PAIRED = 20
"""Most plans on a front to compare each with all cheaper ones; else with the next cheaper and the cheapest only."""


def page_data(scenario: Scenario, front: Front, recordings: Mapping[int, Recording]) -> dict[str, Any]:
    """Return the page's data, JSON-ready; `recordings` are of some plans, by their numbers on the front."""
    problem = scenario.problem()
    plan_map = map_of(scenario)
    graphs = {} if plan_map else routes(scenario, front)
    title, axes = titles(scenario), _axes(scenario, front)
    plans = [
        NamedPlan(
            plan, Ledger.of_plan(problem, plan), "the cheapest" if not i and problem.is_bi_objective else f"plan {i}"
        )
        for i, plan in enumerate(front)
    ]
    return {
        "scenario": scenario.name,
        "objectives": None if problem.is_bi_objective else list(problem.objective_names),
        "complete": front.complete,
        "wishes": not problem.is_bi_objective and len(front) > 1,
        **axes,
        "map": {"size": list(plan_map.size)} if plan_map else None,
        "tasks": [
            _task(task, problem.display.task(task.name), title[task.name], automaton.dead)
            for task, automaton in zip(problem.tasks, problem.automata, strict=True)
        ],
        "rules": [_rule(rule) for rule in problem.rules],
        "plans": [
            {
                **_plan(scenario, plans, i, recordings.get(i), MOVE_TIME_S if plan_map else ACTION_TIME_S),
                "rank": _rank(problem, front, i, axes["ranks"][i]),
                "path": plan_map.trail(named.plan).states.tolist() if plan_map else None,
                "graph": {"at": graph.at, "note": graph.note, "words": graph.words} if graph else None,
            }
            for i, named in enumerate(plans)
            for graph in [graphs.get(i)]
        ],
    }


def check_plan(problem: Problem, plan: Plan, ledger: Ledger) -> Iterator[Check]:
    """Check a plan's costs, tasks, relaxations and preferences by their definitions, and yield the checks.

    Labels and costs of the actions are taken from the ledger, and so are the claimed task costs in all but the first
    cost.
    """
    yield Check("actions", True, f"each of the {len(plan.actions)} is applicable in its state")
    columns = [ledger.costs, *ledger.more_costs.values()]
    bound = list(zip(problem.objectives, problem.preferences, strict=True))
    for d, name in enumerate(problem.cost_names):
        unweighed: list[tuple[Measure | None, Preference]] = [(None, WeightedSum({}))]
        own = [(objective, named.preference) for objective, named in bound if objective.cost == d] or unweighed
        for k, (objective, preference) in enumerate(own):
            mu = plan.preferences[objective.name] if objective else 0
            if objective and objective is problem.objectives[0]:
                mu = plan.preference
            claims = Claims(
                completed=True,
                cost=cast(float, plan.costs[name] if d else plan.cost),
                task_costs=cast("dict[str, int | float]", ledger.task_costs(d) if d else plan.task_costs),
                violation_costs=cast("dict[str, int | float]", plan.violation_costs),
                preference=cast(float, mu),
                relaxations=plan.relaxations,
            )
            verdict = judge(claims, problem.tasks, preference, ledger.labels, columns[d], rules=problem.rules)
            for check in verdict.checks:
                if check.name == "preference":
                    if objective:
                        yield replace(check, name=objective.name)
                elif k == 0 and (d == 0 or "cost" in check.name):
                    yield replace(check, name=check.name.replace("total cost", f"total {name}"))


def _axes(scenario: Scenario, front: Front) -> dict[str, Any]:
    """Return, JSON-ready, the sorted values of each objective on the front, and the ranks of each plan's values.

    The page compares values by their ranks, since JavaScript's floats could not tell all apart.
    """
    names, unit = front.objectives, cost_unit(scenario)
    if names and scenario.problem().is_bi_objective:
        names = (f"Total cost ({unit})" if unit else "Total cost", "Penalty")
    columns = [sorted({plan.objectives[name] for plan in front}) for name in front.objectives]
    return {
        "axes": [
            {"name": name, "values": values, "texts": [*map(number, values)]}
            for name, values in zip(names, columns, strict=True)
        ],
        "ranks": [[*map(bisect_left, columns, plan.objectives.values())] for plan in front],
    }


def _rank(problem: Problem, front: Front, i: int, ranks: Sequence[int]) -> str | None:
    """Return what a point at an end of a front is called, or None; the end of an unfinished front is unknown."""
    if not problem.is_bi_objective:
        least = [name for name, rank in zip(front.objectives, ranks, strict=True) if rank == 0]
        return f"least {', '.join(least)}" if least and front.complete else None
    if len(front) == 1:
        return "the best in both" if front.complete else None
    if i == len(front) - 1 and front.complete:
        return "the preferred plan"
    return None if i else "the cheapest plan"


def _plan(
    scenario: Scenario, plans: Sequence[NamedPlan], i: int, recording: Recording | None, period: float
) -> dict[str, Any]:
    """Return all that the page shows of a plan; without a recording, each action takes the time `period`, s."""
    problem, (plan, planned) = scenario.problem(), (plans[i].plan, plans[i].ledger)
    shown, run = planned, None
    times = [(k * period, (k + 1) * period) for k in range(len(plan.actions))]
    if recording is not None:
        shown, run = _observed(problem, planned, recording), _run(recording, plan)
        begin = float(recording.proof.log.times[0])
        times = [(action.start - begin, action.end - begin) for action in recording.proof.log.about.actions]
    cheaper = range(i) if len(plans) <= MAX_PAIRED else sorted({i - 1, 0} - {i, -1})
    explained: dict[int | None, Explanation] = {j: explain(scenario, plans[i], plans[j]) for j in cheaper}
    if not explained:
        explained[None] = explain_cheapest(scenario, plans[0])
    return {
        "index": i,
        **plan_json(plan),
        "worth": objectives_text(plan),
        "explanations": [{"against": j, "headline": one[0], "details": one[1]} for j, one in explained.items()],
        "shares": [asdict(share) for share in shares(scenario.preference, plan)] if problem.is_bi_objective else [],
        "positions": {task: ordinal(place) for place, task in enumerate(planned.order)},
        "ledger": _ledger(shown),
        "times": [[round(start, 3), round(end, 3)] for start, end in times],
        "checks": [asdict(check) for check in check_plan(problem, plan, planned)],
        "run": run,
    }


def _ledger(ledger: Ledger) -> dict[str, Any]:
    return {
        "actions": [*map(ledger.problem.display.action, ledger.actions)],
        "costs": [number(to_number(cost)) for cost in ledger.costs],
        "spent": [to_number(cost) for cost in ledger.spent],
        "tasks": {
            name: {
                "states": states and list(states),
                "satisfied": ledger.satisfied[name],
                "advances": list(ledger.advances(name)),
                "bought": [
                    {"step": bought.step, "words": bought.words(ledger.problem.display.task(name))}
                    for bought in ledger.relaxations
                    if bought.task == name
                ],
            }
            for name, states in ledger.states.items()
        },
    }


def _observed(problem: Problem, planned: Ledger, recording: Recording) -> Ledger:
    about = recording.proof.log.about
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
        "begin": float(recording.proof.log.times[0]),
        "log": recording.proof.path.name,
        "completed": outcome["completed"],
        "reason": outcome.get("reason"),
        "as_planned": outcome["executed"] == list(plan.actions),
        "replans": outcome["replans"],
        "certificate": recording.certificate,
    }


def _rule(rule: Rule) -> dict[str, str]:
    price = "" if rule.skip is None else f"; it may be broken once, for {number(rule.skip)}"
    never = rule.tree
    if isinstance(never, Until) and (never.left, never.low, never.high) == (TRUE, 0, None):
        never = never.right  # never `F a` means never `a`
    return {
        "name": rule.name,
        "words": f"never: {words_of(never)}{price}",
    }


def _task(task: Task, shown: str, title: str, dead: int | None) -> dict[str, Any]:
    offers = []
    for one in task.relax:
        where = "anywhere" if one.when == "true" else f"where {one.when} holds"
        offers.append(f"{one.assume} may count as true {where}, for {number(one.cost)} each time")
    if task.skip is not None:
        offers.append(f"it may be skipped, for {number(task.skip)}")
    return {
        "name": task.name,
        "shown": shown,
        "title": title,
        "formula": " ".join(task.formula.split()),
        "words": words_of(task.tree),
        "dead": dead,
        "offers": offers,
    }
