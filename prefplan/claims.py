"""Claims about a plan or a run, checked against its trace and the costs of its actions.

Tasks are checked by the semantics of their formulas (`prefplan.logic.good_prefix`), costs and mu by their definitions.
Neither the planner's automata nor the sums of `prefplan.ledger` are used, on purpose: these are what is checked.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate

from prefplan.exact_costs import exact, prints_as, to_number
from prefplan.logic.formula import holds
from prefplan.logic.good_prefix import Label, satisfied_at
from prefplan.logic.tasks import Rule, Task
from prefplan.plan import Purchase
from prefplan.preferences.kinds import Preference


@dataclass(frozen=True)
class Check:
    """A claim that was checked.

    Attributes:
        name: name of the claim, e.g. `task cost phi1`.
        holds: whether it holds.
        words: the findings, in words.
        finding: whether the run did something wrong, but is not refuted, since it is not claimed to be completed.
    """

    name: str
    holds: bool
    words: str
    finding: bool = False


@dataclass(frozen=True)
class Claims:
    """The claims about a plan or a run.

    Attributes:
        completed: whether every task was satisfied, as far as it was not relaxed or skipped.
        cost: total cost (equation 1).
        task_costs: c_i by task name (equation 2).
        violation_costs: v_i by task name.
        preference: mu; None for a run that was not completed.
        relaxations: the relaxations used.
    """

    completed: bool
    cost: int | float
    task_costs: dict[str, int | float]
    violation_costs: dict[str, int | float]
    preference: int | float | None
    relaxations: tuple[Purchase, ...] = ()

    def against(self, name: str, words: str) -> Check:
        """Return a check for what no completed run does: it refutes that claim; if it is not made, it is a finding."""
        return Check(name, not self.completed, words, finding=not self.completed)


@dataclass(frozen=True)
class Verdict:
    """The result of checking claims.

    Attributes:
        checks: one for each claim.
        completed: whether every task is satisfied, as far as it is not relaxed or skipped.
        task_costs: c_i by task name, derived.
        preference: mu, derived.
    """

    checks: tuple[Check, ...]
    completed: bool
    task_costs: Mapping[str, int | float]
    preference: int | float


def judge(
    claims: Claims,
    tasks: Sequence[Task],
    preference: Preference,
    trace: Sequence[Label],
    costs: Sequence[Fraction],
    *,
    rules: Sequence[Rule] = (),
) -> Verdict:
    """Check claims by their definitions.

    `trace` (K + 1,) has the labels at the start and after each of K actions; `costs` (K,) has the actions' costs.
    """
    broken = {rule.name: satisfied_at(rule.tree, trace) for rule in rules}
    offered = _check_relaxations(claims, tasks, trace, {rule.name: (rule, broken[rule.name]) for rule in rules})
    spent = list(accumulate(costs, initial=Fraction(0)))
    ends = {task.name: _satisfied(task, trace, claims) for task in tasks}
    skipped = [b.task for b in claims.relaxations if b.assume is None] if offered.holds else []
    task_costs = [spent[-1] if end is None else spent[end] for end in ends.values()]
    priced = [*ends, *(rule.name for rule in rules if rule.skip is not None)]
    violations = [sum((exact(b.cost) for b in claims.relaxations if b.task == name), Fraction(0)) for name in priced]
    breakable = priced[len(ends) :]
    amounts = [*task_costs, *[Fraction(0)] * len(breakable)], violations
    terms = preference.terms(list(ends), *([breakable] if breakable else []))
    values = (term if isinstance(term, Fraction) else term.value(*amounts) for term in terms)
    mu = to_number(sum(values, Fraction(0)))
    derived = dict(zip(ends, map(to_number, task_costs), strict=True))
    missing = [name for name, end in ends.items() if end is None and name not in skipped]

    checks = []
    if claims.relaxations or any(task.relax or task.skip is not None for task in tasks):
        checks.append(offered)
    checks += [_check_rule(rule, broken[rule.name], claims) for rule in rules]
    checks.append(_check_number("total cost", claims.cost, to_number(spent[-1])))
    checks += [_check_number(f"task cost {name}", claims.task_costs.get(name), cost) for name, cost in derived.items()]
    for name, violation in zip(priced, violations, strict=True):
        claim = claims.violation_costs.get(name)
        if claim or violation:
            checks.append(_check_number(f"violation cost {name}", claim, to_number(violation)))
    unknown = sorted({*claims.task_costs, *claims.violation_costs} - {*priced})
    if unknown:
        checks.append(Check(f"task {unknown[0]}", False, "there is no such task"))
    if claims.completed or claims.preference is not None:
        checks.append(_check_number("preference", claims.preference, mu))
    checks.append(_check_completed(claims, [name for name in ends if name not in skipped], missing, skipped))
    return Verdict(tuple(checks), not missing, derived, mu)


def _satisfied(task: Task, trace: Sequence[Label], claims: Claims) -> int | None:
    """Return after how many actions the trace, with the relaxations used, satisfies a task; None for never."""
    purchases = [purchase for purchase in claims.relaxations if purchase.task == task.name]
    if any(purchase.assume is None for purchase in purchases):
        return None
    read = [label | {p.assume for p in purchases if p.assume and p.step == k} for k, label in enumerate(trace)]
    return satisfied_at(task.tree, read)


def _check_rule(rule: Rule, broken: int | None, claims: Claims) -> Check:
    """Check that a rule is kept, or that its price was paid if it was broken; a run that failed may have broken it."""
    name = f"rule {rule.name}"
    if broken is None:
        return Check(name, True, "kept")
    when = f"broken by action {broken}" if broken else "broken at the start"
    is_paid = any(purchase.rule and purchase.task == rule.name for purchase in claims.relaxations)
    return Check(name, True, f"{when}, which was paid for") if is_paid else claims.against(name, when)


def _check_relaxations(
    claims: Claims, tasks: Sequence[Task], trace: Sequence[Label], rules: Mapping[str, tuple[Rule, int | None]]
) -> Check:
    """Check that every relaxation is one that the problem offers, at that step and for that price."""
    by_name = {task.name: task for task in tasks}
    for purchase in claims.relaxations:
        if purchase.rule:
            rule, step = rules.get(purchase.task, (None, None))
            if not rule or rule.skip is None or not prints_as(rule.skip, purchase.cost) or step != purchase.step:
                words = f"{purchase.task} is not a rule that may be broken at step {purchase.step} for {purchase.cost}"
                return Check("relaxations", False, words)
            continue
        task = by_name.get(purchase.task)
        problem = f"there is no task {purchase.task}" if task is None else _objection(purchase, task, trace)
        if problem:
            return Check("relaxations", False, problem)
    number = len(claims.relaxations)
    return Check("relaxations", True, f"{number} used, as offered" if number else "none is used")


def _objection(purchase: Purchase, task: Task, trace: Sequence[Label]) -> str | None:
    """Return why a relaxation of a task is not valid, or None if it is."""
    if purchase.assume is None:
        if task.skip is not None and prints_as(task.skip, purchase.cost) and purchase.step == 0:
            return None
        return f"{task.name} cannot be skipped for {purchase.cost} at step {purchase.step}"
    what = f"{purchase.assume} at step {purchase.step} of {task.name}, for {purchase.cost},"
    if not 0 <= purchase.step < len(trace):
        return f"{what} lies beyond the last action"
    offers = [r for r in task.relax if r.assume == purchase.assume and prints_as(r.cost, purchase.cost)]
    if not offers:
        return f"{what} is not offered"
    label = trace[purchase.step]
    if purchase.assume in label or not any(holds(offer.condition, label) for offer in offers):
        return f"{what} is not offered there: {', '.join(sorted(label)) or 'nothing'} holds"
    return None


def _check_number(name: str, claim: int | float | None, derived: int | float) -> Check:
    if claim is None:
        return Check(name, False, f"nothing is claimed; it is {derived}")
    # Claims and derived values are rounded to floats where they are not whole.
    try:
        agree = math.isclose(claim, derived, rel_tol=1e-9)
    except OverflowError:
        agree = claim == derived
    return Check(name, agree, f"{derived}" if agree else f"{claim} is claimed, but it is {derived}")


def _check_completed(claims: Claims, done: list[str], missing: list[str], skipped: list[str]) -> Check:
    if claims.completed and missing:
        return Check("completed", False, f"not satisfied: {', '.join(missing)}")
    if not claims.completed:
        why = f"{', '.join(missing)} not satisfied" if missing else "though every task is satisfied"
        return Check("completed", True, f"not claimed: {why}")
    words = f"{', '.join(done)} satisfied" if done else "nothing had to be done"
    return Check("completed", True, words + (f"; {', '.join(sorted(skipped))} skipped" if skipped else ""))
