"""Why a plan costs more than another one, and what it gains: sentences derived from the two plans."""

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product

from experiments.report.differences import Parking, common, landmarks, set_aside
from experiments.report.preference_words import shares
from experiments.runs.formula_words import titles
from prefplan import GraphModel, GridModel, Ledger, ManipulationModel, Order, Plan, Scenario
from prefplan.exact_costs import Number, exact, to_number
from prefplan.scenario.decode import Model
from prefplan.text.layout import condense, counted, listed, number

Explanation = tuple[str, list[str]]
"""A headline on why a plan costs what it costs, and further sentences."""


@dataclass(frozen=True)
class NamedPlan:
    """A plan with its ledger and its name in sentences."""

    plan: Plan
    ledger: Ledger
    name: str


def explain_cheapest(scenario: Scenario, cheapest: NamedPlan) -> Explanation:
    """Explain what the cheapest plan costs, and which tasks add to its penalty."""
    plan, name = cheapest.plan, titles(scenario)
    if not scenario.problem().is_bi_objective:
        first, *others = plan.objectives.items()
        beside = [f"{objective} {number(value)}" for objective, value in others]
        return f"No plan takes less {first[0]}.", [f"Beside that: {listed(beside)}."]
    headline = "No plan costs less" if plan.actions else "Nothing has to be done: this plan costs nothing"
    details = list[str]()
    if plan.preference == 0:
        headline += ", and no plan is preferred to it"
    adding = [share for share in shares(scenario.preference, plan) if share.adds > 0]
    if adding:
        words = [f"{name[share.task]}, preferred {share.preferred}, adds {number(share.adds)}" for share in adding]
        details.append(f"Its penalty of {number(plan.preference)}: {'; '.join(words)}.")
    details += [f"{bought.words(plan.display.task(bought.task))}." for bought in plan.relaxations]
    order = cheapest.ledger.order
    if len(order) > 1:
        details.append(f"Order of the tasks: {', '.join(name[task] for task in order)}.")
    return f"{headline}.", details


def explain(scenario: Scenario, plan: NamedPlan, other: NamedPlan) -> Explanation:
    """Explain why a plan costs more than a cheaper one of the same front, `other`, and what it gains."""
    name = titles(scenario)
    if not scenario.problem().is_bi_objective:
        return _explain_several(scenario, plan, other, name)
    extra = number(_minus(plan.plan.cost, other.plan.cost))
    means = _means(scenario.model, plan.ledger, other.ledger)
    gains, losses = _gains(scenario, plan, other, name)
    reason = f"{means} so that {listed(gains)}" if means else listed(gains)
    headline = f"{extra} more than {other.name}: {reason}" + (f", although {listed(losses)}." if losses else ".")
    details = [
        f"Its penalty is {number(plan.plan.preference)} instead of {number(other.plan.preference)}.",
        *_times(plan, other, name),
        *_actions(scenario.model, plan.ledger, other.ledger),
        *(f"{bought.words(plan.plan.display.task(bought.task))}." for bought in plan.plan.relaxations),
    ]
    return headline, details


def _explain_several(scenario: Scenario, plan: NamedPlan, other: NamedPlan, name: Mapping[str, str]) -> Explanation:
    """Explain how a plan differs from another one in several costs and preferences."""
    changes = {key: _minus(value, other.plan.objectives[key]) for key, value in plan.plan.objectives.items()}
    more = [f"{number(change)} more {key}" for key, change in changes.items() if change > 0]
    less = [f"{number(to_number(-exact(change)))} less {key}" for key, change in changes.items() if change < 0]
    means = _means(scenario.model, plan.ledger, other.ledger).rstrip(",")
    gained = f", for {listed(less)}" if less and more else listed(less)
    headline = f"{listed(more)}{gained} than {other.name}" if more or less else f"as good as {other.name}"
    headline = headline[0].upper() + headline[1:] + (f": {means}." if means else ".")
    return headline, [*_times(plan, other, name), *_actions(scenario.model, plan.ledger, other.ledger)]


def _means(model: Model, plan: Ledger, other: Ledger) -> str:
    """Return what a plan does differently, as a clause, or an empty string."""
    mine, theirs = plan.actions, other.actions
    if parked := set_aside(model, plan, other):
        # The first difference explains the others.
        spared = [parking for parking in set_aside(model, other, plan) if parking.obj == parked[0].obj]
        instead = f" instead of {spared[0].where}" if spared else ""
        return _parked(parked[:1] if spared else parked) + instead
    if isinstance(model, GridModel | GraphModel):
        here, there = landmarks(plan), landmarks(other)
        alike = common(here, there)
        on_grid = isinstance(model, GridModel)
        first, then = ("it goes first to", "it goes to") if on_grid else ("it first reaches", "it reaches")
        if alike < len(here):
            reaches = f"after {here[alike - 1]} {then}" if alike else first
            return f"{reaches} {here[alike]}" + (f" instead of {there[alike]}," if alike < len(there) else "")
    if isinstance(model, GridModel):
        moves = len(mine) - len(theirs)
        return f"it makes {counted(moves, 'more move')}" if moves > 0 else ""
    if isinstance(model, ManipulationModel):
        kinds = Counter(model.action(action).kind for action in mine)
        kinds -= Counter(model.action(action).kind for action in theirs)
        if kinds:
            return f"it takes {listed([counted(n, f'more {kind}') for kind, n in kinds.items()])}"
    alike = common(mine, theirs)
    if alike < len(mine):
        show = plan.problem.display.action
        return f"it does {show(mine[alike])}" + (f" instead of {show(theirs[alike])}" if alike < len(theirs) else "")
    return ""


def _gains(
    scenario: Scenario, plan: NamedPlan, other: NamedPlan, name: Mapping[str, str]
) -> tuple[list[str], list[str]]:
    """Return what is better for the preference, and what is worse, as clauses."""
    gains, losses = _relaxed(plan.plan, other.plan, name)
    if not gains and isinstance(scenario.preference, Order):
        groups = scenario.preference.groups(plan.ledger.problem.names)
        gains = list(_overtakings(groups, plan.ledger, other.ledger, name, "before"))
        losses = list(_overtakings(groups, other.ledger, plan.ledger, name, "after"))
    if not gains:
        pairs = zip(shares(scenario.preference, plan.plan), shares(scenario.preference, other.plan), strict=True)
        for now, before in pairs:
            if now.missed is not None and before.missed is not None and now.missed < before.missed:
                words = f", preferred {now.preferred}, is off by {number(now.missed)} instead of"
                if now.missed == 0:
                    words = f" is as preferred, {now.preferred}, instead of off by"
                gains.append(f"{name[now.task]}{words} {number(before.missed)}")
    if not gains:
        for task, cost in plan.plan.task_costs.items():
            if _minus(other.plan.task_costs[task], cost) > 0:
                gains.append(f"{name[task]} is done at {number(cost)}, not {number(other.plan.task_costs[task])}")
    return gains, losses


def _overtakings(
    groups: Sequence[Sequence[str]], plan: Ledger, other: Ledger, name: Mapping[str, str], side: str
) -> Iterator[str]:
    """Yield which tasks are done before tasks preferred later, but not before them in the other plan, as clauses."""
    later = defaultdict[str, list[str]](list)
    for first, then in combinations(groups, 2):
        for task, behind in product(first, then):
            if _before(plan, task, behind) and not _before(other, task, behind):
                later[task].append(name[behind])
    for behind in dict.fromkeys(map(listed, later.values())):
        tasks = [name[task] for task, overtaken in later.items() if listed(overtaken) == behind]
        yield f"{listed(tasks)} {'is' if len(tasks) == 1 else 'are'} done {side} {behind}"


def _before(ledger: Ledger, one: str, other: str) -> bool:
    first, then = ledger.satisfied[one], ledger.satisfied[other]
    return first is not None and (then is None or first < then)


def _relaxed(plan: Plan, other: Plan, name: Mapping[str, str]) -> tuple[list[str], list[str]]:
    """Return which tasks are relaxed for less, and which for more, as clauses."""

    def done(plan: Plan, task: str) -> str:
        bought = [purchase for purchase in plan.relaxations if purchase.task == task]
        if not bought:
            return "done as written" if task in plan.task_costs else "kept"
        skipped = any(purchase.assume is None for purchase in bought)
        how = "broken" if bought[0].rule else "skipped" if skipped else "relaxed"
        return f"{how} for {number(plan.violation_costs[task])}"

    changes = {task: _minus(cost, other.violation_costs[task]) for task, cost in plan.violation_costs.items()}
    gains = [f"{name[t]} is {done(plan, t)} instead of {done(other, t)}" for t, change in changes.items() if change < 0]
    losses = [f"{name[t]} is {done(plan, t)}" for t, change in changes.items() if change > 0]
    return gains, losses


def _times(plan: NamedPlan, other: NamedPlan, name: Mapping[str, str]) -> list[str]:
    """Return which tasks are done earlier and later, as sentences."""
    changes: dict[str, list[str]] = {"Done earlier": [], "Done later": []}
    for task, now in plan.plan.task_costs.items():
        before = other.plan.task_costs[task]
        both = plan.ledger.satisfied[task] is not None and other.ledger.satisfied[task] is not None
        if both and exact(now) != exact(before):
            when = "Done earlier" if exact(now) < exact(before) else "Done later"
            changes[when].append(f"{name[task]} at {number(now)} instead of {number(before)}")
    found = [f"{when}: {', '.join(tasks)}." for when, tasks in changes.items() if tasks]
    orders = [", ".join(name[task] for task in one.ledger.order) for one in (plan, other)]
    if orders[0] != orders[1] and all(orders):
        found.append(f"Order of the tasks: {orders[0]}; in the other plan: {orders[1]}.")
    return found


def _actions(model: Model, plan: Ledger, other: Ledger) -> list[str]:
    """Return which actions only one of the plans takes, and what only one of them puts aside, as sentences."""
    if isinstance(model, GridModel):
        return [f"It makes {len(plan.actions)} moves, the other plan {len(other.actions)}."]
    found, aside = [], []
    for which, one, another in (("this", plan, other), ("the other", other, plan)):
        if extra := Counter(one.actions) - Counter(another.actions):
            taken = sorted(extra.elements(), key=one.actions.index)
            found.append(f"Only in {which} plan: {condense([*map(plan.problem.display.action, taken)])}.")
        if parked := set_aside(model, one, another):
            aside.append(f"For a while, in {which} plan: {_parked(parked)}.")
    return (found or ["Both take the same actions, in another order."]) + aside


def _parked(parked: Sequence[Parking]) -> str:
    return listed([f"{parking.obj} is put aside {parking.where}" for parking in parked])


def _minus(one: Number, other: Number) -> Number:
    return to_number(exact(one) - exact(other))
