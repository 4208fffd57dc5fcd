"""A preference in words, and the share of each task in its penalty."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import chain

from prefplan import Deadline, Expression, Max, Order, Plan, Preference, Sum, WeightedSum
from prefplan.exact_costs import Number, exact, to_number
from prefplan.text.layout import listed, number
from prefplan.text.names import DisplayNames

ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth")


@dataclass(frozen=True)
class Share:
    """The share of one task in the penalty of a plan.

    Attributes:
        task: its name.
        preferred: what the preference asks of it, e.g. `second` or `by 17`.
        missed: by how much it misses its place or limit; None if it has neither.
        adds: its share.
    """

    task: str
    preferred: str
    missed: int | float | None
    adds: int | float


def ordinal(place: int) -> str:
    """Return the ordinal of a place that is counted from 0."""
    return ORDINALS[place] if place < len(ORDINALS) else f"{place + 1}th"


def in_words(preference: Preference, tasks: Sequence[str], display: DisplayNames) -> str:
    """Return what a penalty over tasks means, as a sentence or two."""
    paid = getattr(preference, "over", "cost") == "violation"
    amount = "violation cost" if paid else "cost"
    match preference:
        case Order():
            groups = preference.groups(tasks)
            steps = [listed([*map(display.task, group)]) + " in any order" * (len(group) > 1) for group in groups]
            others = [display.task(name) for name in tasks if name not in chain(*groups)]
            also = f" ({', '.join(others)} weigh nothing)" if others else ""
            return (
                f"Preferred order of the tasks: {', '.join(steps)}{also}. The penalty adds up how late each task is. "
                "The k-th in this order should be done when k tasks are: if it is done at cost 34, and k tasks were "
                "done at 17, it is late by 34 - 17 = 17. 0 means that the order is kept."
            )
        case WeightedSum(weights):
            why = "What is paid to relax tasks counts" if paid else "Early tasks are preferred"
            return f"{why}: the penalty is the sum of the tasks' {amount}s, {_weighted(weights, display)}."
        case Max(weights):
            named = f", each weighted: {_weighted(weights, display)}" if weights else ""
            return f"The worst task counts: the penalty is the largest {amount} of a task{named}."
        case Deadline(deadlines):
            limits = "; ".join(
                f"{display.task(name)}, {_limit(due.by, due.weight, paid)}" for name, due in deadlines.items()
            )
            return f"The penalty adds up by how much the tasks' {amount}s exceed their limits: {limits}."
        case Expression(expression):
            return f"The penalty is {expression}, where a task's name stands for its {amount}."
        case Sum(parts):
            words = [
                f"({i}){_times(weight)} {in_words(part, tasks, display)}" for i, (part, weight) in enumerate(parts, 1)
            ]
            return f"The penalty is the sum of {len(parts)} parts. {' '.join(words)}"
    return "The penalty is a function of the tasks' costs."


def shares(preference: Preference, plan: Plan) -> Iterator[Share]:
    """Yield the shares of the tasks in a plan's penalty.

    The shares add up to the penalty; nothing is yielded if it is not a sum over tasks.
    """
    paid = getattr(preference, "over", "cost") == "violation"
    amounts = {name: exact(cost) for name, cost in (plan.violation_costs if paid else plan.task_costs).items()}
    match preference:
        case Order():
            yield from _delays(preference.groups([*plan.task_costs]), amounts)
        case WeightedSum(weights):
            words = "without relaxation" if paid else "early"
            for name, weight in weights.items():
                yield Share(name, words + _times(weight), None, to_number(exact(weight) * amounts[name]))
        case Deadline(deadlines):
            for name, due in deadlines.items():
                missed, words = max(Fraction(0), amounts[name] - exact(due.by)), _limit(due.by, due.weight, paid)
                yield Share(name, words, to_number(missed), to_number(exact(due.weight) * missed))
        case Sum(parts):
            found = [([*shares(part, plan)], exact(weight)) for part, weight in parts]
            for mine, weight in found if all(mine for mine, _ in found) else ():
                yield from (replace(share, adds=to_number(weight * exact(share.adds))) for share in mine)


def _delays(groups: Sequence[tuple[str, ...]], costs: Mapping[str, Fraction]) -> Iterator[Share]:
    """Yield each task's delay against its place; members of a group take its places in the order they are done."""
    times, first = sorted(costs[name] for name in chain(*groups)), 0
    for group in groups:
        last = first + len(group) - 1
        words = ordinal(first) if first == last else f"{ordinal(first)} to {ordinal(last)}"
        for place, name in enumerate(sorted(group, key=costs.__getitem__), first):
            delay = to_number(max(Fraction(0), costs[name] - times[place]))
            yield Share(name, words, delay, delay)
        first = last + 1


def _limit(by: Number, weight: Number, paid: bool) -> str:
    return f"{'for at most' if paid else 'by'} {number(by)}{_times(weight)}"


def _weighted(weights: Mapping[str, Number], display: DisplayNames) -> str:
    pairs = {display.task(name): exact(weight) for name, weight in weights.items() if exact(weight) != 0}
    return " + ".join(name if w == 1 else f"{number(to_number(w))} × {name}" for name, w in pairs.items())


def _times(weight: Number) -> str:
    return "" if exact(weight) == 1 else f" (weight {number(weight)})"
