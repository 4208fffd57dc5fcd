"""The certificate of a run: from its log alone, everything that is said of it is derived again.

The propositions after each action are read off the recorded frames (`sim.evidence.replay`), the tasks are judged on
that trace by what their formulas mean (`prefplan.logic.good_prefix`), and costs and mu follow from the definitions.
Neither the automata that the planner followed nor the observations by which the run went have a say.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from prefplan.exact_costs import exact, to_number
from prefplan.logic.formula import holds, parse
from prefplan.logic.good_prefix import Label, satisfied_at
from prefplan.models.manipulation.action import at, holding, marked
from prefplan.preferences.objective import Measure
from prefplan.problem import Task
from sim.evidence.check import Check
from sim.evidence.cost_checks import check_action_costs, check_number
from sim.evidence.log import Claims, Log, LoggedAction
from sim.evidence.motion_checks import check_contacts, check_leaps, check_limits, check_recording
from sim.evidence.replay import RecordedWorld


@dataclass(frozen=True)
class Certificate:
    """What came of checking a log.

    Attributes:
        claims: checks of what is said of the run: that it was completed, at what costs, and what each action did.
        motions: checks of how it moved: joint limits, leaps of objects, contacts.
        completed: whether every task was satisfied on the recorded states, as far as it was not relaxed.
        task_costs: c_i by task name, derived.
        preference: mu, derived.
    """

    claims: tuple[Check, ...]
    motions: tuple[Check, ...]
    completed: bool
    task_costs: Mapping[str, int | float]
    preference: int | float

    @property
    def checks(self) -> tuple[Check, ...]:
        """All of them."""
        return self.claims + self.motions

    @property
    def agrees(self) -> bool:
        """Whether everything that is said of the run is true."""
        return all(check.holds for check in self.claims)

    @property
    def confirmed(self) -> bool:
        """Whether every check holds."""
        return all(check.holds for check in self.checks)

    @property
    def refuted(self) -> tuple[Check, ...]:
        """The checks that do not hold."""
        return tuple(check for check in self.checks if not check.holds)

    def check(self, name: str) -> Check:
        """Return a check by its name."""
        return next(check for check in self.checks if check.name == name)


def certify(log: Log) -> Certificate:
    """Check everything that is said of a run against what was recorded of it.

    Raises:
        LogError: the scenario in the log is of no use, so that nothing can be checked.
    """
    world = RecordedWorld(log)
    scenario, about, claims = world.scenario, log.about, log.about.claims
    recording = check_recording(log)
    trace, effects = _trace(log, world)
    purchases = _check_purchases(scenario.tasks, claims, trace)
    costs = check_action_costs(log, world, trace)
    spent = [Fraction(0)]
    for action in about.actions:
        spent.append(spent[-1] + exact(action.cost))
    ends = {task.name: _satisfied(task, trace, claims) for task in scenario.tasks}
    skipped = {bought.task for bought in claims.relaxations if bought.assume is None} if purchases.holds else set()
    task_costs = {name: spent[-1] if end is None else spent[end] for name, end in ends.items()}
    violations = {
        task.name: sum((exact(b.cost) for b in claims.relaxations if b.task == task.name), Fraction(0))
        for task in scenario.tasks
    }
    measure = Measure.of(scenario.preference.terms(list(ends)), len(ends))
    mu = to_number(measure.value(list(task_costs.values()), list(violations.values())))
    missing = [name for name, end in ends.items() if end is None and name not in skipped]
    checks = [recording, _check_start(world, trace[0]), *effects, costs]
    if any(task.relax or task.skip is not None for task in scenario.tasks) or claims.relaxations:
        checks.append(purchases)
    checks.append(check_number("total cost", claims.cost, to_number(spent[-1])))
    for name in ends:
        checks.append(check_number(f"task cost {name}", claims.task_costs.get(name), to_number(task_costs[name])))
    for name in ends:
        if violations[name] or claims.violation_costs.get(name):
            derived = to_number(violations[name])
            checks.append(check_number(f"violation cost {name}", claims.violation_costs.get(name), derived))
    if claims.completed or claims.preference is not None:
        checks.append(check_number("preference", claims.preference, mu))
    checks.append(_check_completed(claims, missing, ends, skipped))
    motions = (*check_limits(log, world), check_leaps(log, world), check_contacts(log, world))
    numbers = {name: to_number(cost) for name, cost in task_costs.items()}
    return Certificate(tuple(checks), motions, not missing, numbers, mu)


def _trace(log: Log, world: RecordedWorld) -> tuple[list[Label], list[Check]]:
    """Return the labels at the start and after every action, and whether each action did what is said of it.

    An object earns a location's mark when it is released there: it was held as that action began, the location worked
    on it, and it rests there at the end.
    """
    own = world.model.own_propositions
    marks = {place.name: place.marks for place in world.model.locations if place.marks}
    world.show(0)
    label = _observed(world) & own
    earned: set[str] = set()
    trace, checks = [label], []
    said = label
    for k, action in enumerate(log.about.actions, 1):
        world.show(world.frame_at(action.end))
        symbolic = world.action(action.action)
        effect = world.model.effect(symbolic) & own if symbolic else frozenset()
        before, label = label, _observed(world) & own
        if symbolic and symbolic.location in marks:
            obj, place = symbolic.obj, symbolic.location
            worked = world.worked(place, start=action.start, end=action.end)
            if at(obj, place) in effect & label and worked and holding(obj) in before:
                earned.add(marked(obj, marks[place]))
        label = label | earned
        trace.append(label)
        said, told = frozenset(action.label) & own, said
        unseen = label != said == told and k == len(log.about.actions) and not log.about.claims.completed
        checks.append(_check_effect(k, action, label, None if unseen else said, effect))
    return trace, checks


def _observed(world: RecordedWorld) -> frozenset[str]:
    """Return the propositions, marks aside, that hold in the frame that is shown."""
    held = world.held()
    names = set() if held is None else {holding(held)}
    names |= {at(obj, place) for obj, place in world.resting(held).items()}
    return frozenset(names)


def _check_effect(k: int, action: LoggedAction, label: Label, said: Label | None, effect: frozenset[str]) -> Check:
    """Check what an action led to; `said` is None where the run ended without an observation."""
    name, what = f"action {k}", f"`{action.action}`"
    if said is None:
        return Check(name, True, f"{what}: the last one; the run ended without seeing a change")
    if label != said:
        found, told = (", ".join(sorted(names)) or "nothing" for names in (label - said, said - label))
        return Check(name, False, f"{what}: the frames show {found}, the record tells {told} instead")
    if not effect <= label:
        return Check(name, True, f"{what} failed, as the record tells")
    return Check(name, True, f"{what}: {', '.join(sorted(effect)) or 'nothing else changed'}")


def _check_start(world: RecordedWorld, label: Label) -> Check:
    """Check that every object starts where the scenario says."""
    wrong = [obj for obj in world.model.objects if at(obj.name, obj.start) not in label]
    if wrong:
        return Check("start", False, f"{wrong[0].name} does not start at {wrong[0].start}")
    return Check("start", True, "every object is where the scenario has it")


def _check_purchases(tasks: tuple[Task, ...], claims: Claims, trace: list[Label]) -> Check:
    """Check that every relaxation is one that the scenario offers, where and for what it was bought."""
    name = "relaxations"
    by_name = {task.name: task for task in tasks}
    for bought in claims.relaxations:
        task = by_name.get(bought.task)
        if task is None:
            return Check(name, False, f"there is no task {bought.task}")
        if bought.assume is None:
            if task.skip is None or exact(task.skip) != exact(bought.cost) or bought.step != 0:
                return Check(name, False, f"{task.name} cannot be skipped for {bought.cost} at step {bought.step}")
            continue
        what = f"{bought.assume} at step {bought.step} of {task.name}, for {bought.cost},"
        if not 0 <= bought.step < len(trace):
            return Check(name, False, f"{what} lies beyond the last action")
        offers = [r for r in task.relax if r.assume == bought.assume and exact(r.cost) == exact(bought.cost)]
        if not offers:
            return Check(name, False, f"{what} is not on offer")
        label = trace[bought.step]
        if bought.assume in label or not any(holds(parse(offer.when), label) for offer in offers):
            return Check(name, False, f"{what} is not on offer there: {', '.join(sorted(label)) or 'nothing'} holds")
    if not claims.relaxations:
        return Check(name, True, "none is used")
    return Check(name, True, f"{len(claims.relaxations)} used, as offered")


def _satisfied(task: Task, trace: list[Label], claims: Claims) -> int | None:
    """Return after how many actions a task is satisfied on the trace, read as its relaxations allow, or None."""
    mine = [bought for bought in claims.relaxations if bought.task == task.name]
    if any(bought.assume is None for bought in mine):
        return None
    read = [label | {b.assume for b in mine if b.assume and b.step == k} for k, label in enumerate(trace)]
    return satisfied_at(parse(task.formula), read)


def _check_completed(claims: Claims, missing: list[str], ends: Mapping[str, Any], skipped: set[str]) -> Check:
    name = "completed"
    if claims.completed and missing:
        return Check(name, False, f"not satisfied on the recorded states: {', '.join(missing)}")
    if not claims.completed:
        still = f"{', '.join(missing)} not satisfied" if missing else "though every task is satisfied"
        return Check(name, True, f"not claimed: {still}")
    done = [task for task in ends if task not in skipped]
    words = f"{', '.join(done)} satisfied on the recorded states" if done else "nothing had to be done"
    return Check(name, True, words + (f"; {', '.join(sorted(skipped))} skipped" if skipped else ""))
