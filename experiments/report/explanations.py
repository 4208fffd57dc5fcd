"""Why a plan costs more than another one, and what it gives for that: sentences derived from the two plans."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from experiments.cli.output import condense, number
from experiments.report.differences import Differences, Parking, differences
from experiments.report.timeline import Timeline
from experiments.report.wishes import ordinal, wishes
from prefplan.exact_costs import Number, exact, to_number
from prefplan.front import Plan, Purchase
from prefplan.logic.formula import And, Formula, Literal, Next, Or, Until, parse
from prefplan.models.grid import GridModel
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.preferences.kinds import Order
from prefplan.problem import Task
from prefplan.scenario.decode import Model, Scenario


@dataclass(frozen=True)
class Explanation:
    """Why a plan costs what it costs.

    Attributes:
        headline: one sentence.
        details: more of them, each on its own.
    """

    headline: str
    details: tuple[str, ...]


@dataclass(frozen=True)
class Told:
    """A plan with its timeline and what sentences call it."""

    plan: Plan
    timeline: Timeline
    name: str


def titles(scenario: Scenario) -> dict[str, str]:
    """Return what each task is called: its name, with the object it is about where that is one of its own."""
    subjects = {task.name: _subject(task, scenario.model) for task in scenario.tasks}
    count = Counter(subjects.values())
    found = {}
    for name, subject in subjects.items():
        distinct = subject is not None and count[subject] == 1 and subject != name
        found[name] = f"{name} ({subject})" if distinct else name
    return found


def explain_cheapest(scenario: Scenario, cheapest: Told) -> Explanation:
    """Explain why the cheapest plan is not simply the best one, or that it is."""
    plan, name = cheapest.plan, titles(scenario)
    if not plan.actions:
        headline = "Nothing has to be done: this plan costs nothing."
    else:
        headline = "No plan costs less."
    details = []
    if exact(plan.preference) == 0:
        headline = headline[:-1] + ", and it is all that the preference wishes."
    else:
        short = [w for w in wishes(scenario.preference, plan) if exact(w.adds) > 0]
        if short:
            words = [f"{name[w.task]}, wished {w.words}, adds {number(w.adds)}" for w in short]
            details.append(f"Its preference of {number(plan.preference)}: {'; '.join(words)}.")
    details += _paid(plan.relaxations, name)
    order = cheapest.timeline.order
    if len(order) > 1:
        details.append(f"Tasks are done in this order: {', '.join(name[n] for n in order)}.")
    return Explanation(headline, tuple(details))


def explain(scenario: Scenario, plan: Told, other: Told) -> Explanation:
    """Explain why a plan costs more than a cheaper one of the same front, and what it gives for that.

    Args:
        scenario: what both are plans for.
        plan: the dearer plan.
        other: the cheaper one, of a greater preference value.
    """
    problem = scenario.problem()
    name = titles(scenario)
    apart = differences(scenario.model, problem, plan.timeline, other.timeline)
    extra = number(_minus(plan.plan.cost, other.plan.cost))
    means = _means(scenario.model, plan, other, apart)
    gains, losses = _gains(scenario, plan, other, name)
    reason = f"{means} so that {_all(gains)}" if means else _all(gains)
    headline = f"{extra} more than {other.name}: {reason}" + (f", though {_all(losses)}." if losses else ".")
    details = [
        f"Its preference is {number(plan.plan.preference)} instead of {number(other.plan.preference)}.",
        *_times(plan, other, name),
        *_work(scenario.model, apart, plan, other),
        *_aside(scenario.model, apart),
        *_paid(plan.plan.relaxations, name),
    ]
    return Explanation(headline, tuple(details))


def _means(model: Model, plan: Told, other: Told, apart: Differences) -> str:
    """Return what a plan does otherwise, as a clause; empty where there is nothing to say."""
    if apart.parked:
        # The first one is what the others follow from.
        first, *rest = apart.parked
        clause = f"{first.thing} is parked {_at(model, first.place)}"
        instead = [one for one in apart.spared if one.thing == first.thing]
        if instead:
            return f"{clause} rather than {_at(model, instead[0].place)}"
        return clause + "".join(f" and {one.thing} {_at(model, one.place)}" for one in rest)
    if isinstance(model, GridModel):
        if apart.here != apart.there and apart.here:
            away = f"from {apart.last} it goes" if apart.last else "it goes first"
            return f"{away} to {apart.here}" + (f", not to {apart.there}," if apart.there else "")
        moves = len(plan.timeline.actions) - len(other.timeline.actions)
        return f"it goes a longer way, by {moves} {'move' if moves == 1 else 'moves'}," if moves > 0 else ""
    if isinstance(model, ManipulationModel):
        kinds = Counter(model.action(action).kind for action in plan.timeline.actions)
        kinds -= Counter(model.action(action).kind for action in other.timeline.actions)
        if kinds:
            return f"it takes {_all([f'{n} more {kind}' + 's' * (n > 1) for kind, n in kinds.items()])}"
    if plan.timeline.actions[apart.part :]:
        ahead = plan.timeline.actions[apart.part]
        rather = other.timeline.actions[apart.part :]
        return f"it does {ahead}" + (f" rather than {rather[0]}" if rather else "")
    return ""


def _gains(scenario: Scenario, plan: Told, other: Told, name: Mapping[str, str]) -> tuple[list[str], list[str]]:
    """Return what the preference gains, as clauses, and what it loses again."""
    gains, losses = _relaxed(plan.plan, other.plan, name)
    if not gains and isinstance(scenario.preference, Order):
        gains = _put_right(scenario.preference, plan.timeline, other.timeline, name)
        losses = _put_wrong(scenario.preference, plan.timeline, other.timeline, name)
    if not gains:
        before = {(w.task, i): w for i, w in enumerate(wishes(scenario.preference, other.plan))}
        for i, wish in enumerate(wishes(scenario.preference, plan.plan)):
            missed = before[wish.task, i].missed
            if missed is None or wish.missed is None or wish.missed >= missed:
                continue
            gains.append(f"{name[wish.task]}, wished {wish.words}, {_nearer(scenario, wish.missed, missed)}")
    if not gains:
        for task, cost in plan.plan.task_costs.items():
            if _minus(other.plan.task_costs[task], cost) > 0:
                gains.append(f"{name[task]} is done at {number(cost)}, not {number(other.plan.task_costs[task])}")
    return gains, losses


def _nearer(scenario: Scenario, missed: Number, before: Number) -> str:
    """Return by how much less a wish is missed; in an order that may be so because the tasks before are done later."""
    if isinstance(scenario.preference, Order):
        turn = f"{number(missed)} after its turn" if missed else "in its turn"
        return f"is done {turn} instead of {number(before)} after it"
    now = f"misses that by {number(missed)}" if missed else "is so"
    return f"{now} instead of missing it by {number(before)}"


def _put_right(wished: Order, plan: Timeline, other: Timeline, name: Mapping[str, str]) -> list[str]:
    """Return which tasks now come before others as they should, while in the other plan they did not."""
    found = []
    overtaken: dict[tuple[str, ...], list[str]] = {}
    rank = _ranks(wished, name)
    for task, behind in _overtaken(rank, plan, other):
        place = plan.order.index(task)
        if rank[task] == place and plan.order[:place] == tuple(sorted(plan.order[:place], key=rank.__getitem__)):
            last = place == len(plan.order) - 1
            found.append(f"{name[task]} is done {'last' if last else ordinal(place)}")
        else:
            overtaken.setdefault(tuple(name[later] for later in behind), []).append(name[task])
    for later, tasks in overtaken.items():
        found.append(f"{_all(tasks)} {'is' if len(tasks) == 1 else 'are'} done before {_all(later)}")
    return found


def _put_wrong(wished: Order, plan: Timeline, other: Timeline, name: Mapping[str, str]) -> list[str]:
    """Return which tasks no longer come before others as they should."""
    lost = _overtaken(_ranks(wished, name), other, plan)
    return [f"{name[task]} is done after {_all([name[later] for later in behind])}" for task, behind in lost]


def _ranks(wished: Order, name: Mapping[str, str]) -> dict[str, int]:
    return {task: k for k, entry in enumerate(wished.order or tuple(name)) for task in _members(entry)}


def _overtaken(rank: Mapping[str, int], plan: Timeline, other: Timeline) -> list[tuple[str, list[str]]]:
    """Return each task with those wished later that it comes before in one plan, but not in the other."""
    found = []
    for task in sorted(rank, key=rank.__getitem__):
        behind = [
            later
            for later in rank
            if rank[task] < rank[later] and _before(plan, task, later) and not _before(other, task, later)
        ]
        if behind:
            found.append((task, behind))
    return found


def _members(entry: str | tuple[str, ...]) -> tuple[str, ...]:
    return (entry,) if isinstance(entry, str) else tuple(entry)


def _before(timeline: Timeline, one: str, other: str) -> bool:
    first, then = timeline.tracks[one].satisfied, timeline.tracks[other].satisfied
    return first is not None and (then is None or first < then)


def _relaxed(plan: Plan, other: Plan, name: Mapping[str, str]) -> tuple[list[str], list[str]]:
    """Return which tasks are relaxed for less, as clauses, and which are relaxed for more."""
    gains, losses = [], []
    for task in plan.violation_costs:
        now, before = ([b for b in one.relaxations if b.task == task] for one in (plan, other))
        change = _minus(plan.violation_costs[task], other.violation_costs[task])
        if change < 0:
            if not now:
                gains.append(f"{name[task]} is done as it is written instead of {_how(before)}")
            else:
                rather = _how(before).removeprefix("relaxed for ")
                gains.append(f"{name[task]} is relaxed for only {_price(now)} instead of {rather}")
        elif change > 0:
            losses.append(f"{name[task]} is {_how(now)}")
    return gains, losses


def _how(bought: Sequence[Purchase]) -> str:
    how = "skipped" if any(one.assume is None for one in bought) else "relaxed"
    return f"{how} for {_price(bought)}"


def _price(bought: Sequence[Purchase]) -> str:
    return number(to_number(sum((exact(one.cost) for one in bought), Fraction(0))))


def _paid(bought: Sequence[Purchase], name: Mapping[str, str]) -> list[str]:
    found = []
    for one in bought:
        if one.assume is None:
            found.append(f"{name[one.task]} is skipped, for {number(one.cost)}.")
        else:
            when = f"after action {one.step}" if one.step else "at the start"
            found.append(f"{name[one.task]} is relaxed {when}: {one.assume} counts as true, for {number(one.cost)}.")
    return found


def _times(plan: Told, other: Told, name: Mapping[str, str]) -> list[str]:
    """Return which tasks are done earlier and later, as sentences."""
    changes: dict[str, list[str]] = {"Done earlier": [], "Done later": []}
    for task in plan.plan.task_costs:
        if plan.timeline.tracks[task].satisfied is None or other.timeline.tracks[task].satisfied is None:
            continue
        now, before = plan.plan.task_costs[task], other.plan.task_costs[task]
        if exact(now) != exact(before):
            when = "Done earlier" if exact(now) < exact(before) else "Done later"
            changes[when].append(f"{name[task]} at {number(now)} instead of {number(before)}")
    found = [f"{when}: {', '.join(some)}." for when, some in changes.items() if some]
    orders = [", ".join(name[task] for task in one.timeline.order) for one in (plan, other)]
    if orders[0] != orders[1]:
        found.append(f"Tasks are done in the order {orders[0]}; in the other plan {orders[1]}.")
    return found


def _work(model: Model, apart: Differences, plan: Told, other: Told) -> list[str]:
    """Return what is done oftener and less often, as sentences."""
    if isinstance(model, GridModel):
        moves = len(plan.timeline.actions), len(other.timeline.actions)
        return [f"It makes {moves[0]} moves, the other plan {moves[1]}."]
    found = []
    if apart.more:
        found.append(f"Only in this plan: {condense(sorted(apart.more.elements(), key=plan.timeline.actions.index))}.")
    if apart.fewer:
        found.append(
            f"Only in the other: {condense(sorted(apart.fewer.elements(), key=other.timeline.actions.index))}."
        )
    if not found:
        found.append("Both take the same actions, in another order.")
    return found


def _aside(model: Model, apart: Differences) -> list[str]:
    """Return what either puts aside alone, as sentences."""

    def listed(parked: Sequence[Parking]) -> str:
        return _all([f"{one.thing} {_at(model, one.place)}" for one in parked])

    found = []
    if apart.parked:
        found.append(f"Put aside for a while in this plan: {listed(apart.parked)}.")
    if apart.spared:
        found.append(f"Put aside for a while in the other: {listed(apart.spared)}.")
    return found


def _at(model: Model, place: str) -> str:
    inside = isinstance(model, ManipulationModel) and model.location(place).kind == "bin"
    return f"{'in' if inside else 'on'} {place}"


def _subject(task: Task, model: Model) -> str | None:
    """Return the one object whose state a task is after, or None."""
    if not isinstance(model, ManipulationModel):
        return None
    goals = _goals(parse(task.formula))
    found = {thing.name for thing in model.objects if goals & {name for name, _ in model.propositions_of(thing.name)}}
    return found.pop() if len(found) == 1 else None


def _goals(formula: Formula) -> set[str]:
    """Return the propositions that have to come true some time."""
    match formula:
        case Until(_, right):
            return _goals(right)
        case And(left, right) | Or(left, right):
            return _goals(left) | _goals(right)
        case Next(operand):
            return _goals(operand)
        case Literal(name, True):
            return {name}
    return set()


def _minus(one: Number, other: Number) -> Number:
    return to_number(exact(one) - exact(other))


def _all(clauses: Sequence[str]) -> str:
    return clauses[0] if len(clauses) == 1 else f"{', '.join(clauses[:-1])} and {clauses[-1]}"
