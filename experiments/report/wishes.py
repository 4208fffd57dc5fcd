"""What a preference wishes of every task, in words, and how far a plan falls short of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from experiments.cli.output import number
from prefplan.exact_costs import Number, exact, to_number
from prefplan.front import Plan
from prefplan.preferences.kinds import Deadline, Expression, Max, Order, Preference, Sum, WeightedSum

ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth")


@dataclass(frozen=True)
class Wish:
    """What is wished of one task, and what a plan's falling short of it adds to the preference.

    Attributes:
        task: its name.
        words: e.g. `second` or `by 17`.
        missed: by how much a limit is missed; None where there is none to miss.
        adds: what this adds to the preference, weighted.
    """

    task: str
    words: str
    missed: int | float | None
    adds: int | float


def ordinal(place: int) -> str:
    """Return the word for a place, counted from 0."""
    return ORDINALS[place] if place < len(ORDINALS) else f"{place + 1}th"


def in_words(preference: Preference, tasks: Sequence[str]) -> str:
    """Return what a preference wishes, as a sentence or two."""
    match preference:
        case Order(order):
            steps = [entry if isinstance(entry, str) else _either(entry) for entry in order or tasks]
            return (
                f"The tasks would best be done in this order: {', '.join(steps)}. The preference adds up, for every "
                "place in it, how much later the task wished there is done than the one that takes that place; 0 is "
                "exactly as wished."
            )
        case WeightedSum(weights, "violation"):
            return (
                f"The preference adds up what is paid to relax tasks: {_weighted(weights)}. Cost does not matter to it."
            )
        case WeightedSum(weights):
            return (
                f"Every task would best be done early. The preference adds up the tasks' costs: {_weighted(weights)}."
            )
        case Max(weights, over):
            what = "paid to relax" if over == "violation" else "spent until it is done for"
            named = f", weighed {_weighted(weights)}" if weights else ""
            return f"The task that comes off worst counts: the preference is the most that is {what} any task{named}."
        case Deadline(deadlines, over):
            what = "is relaxed for" if over == "violation" else "is done"
            limits = "; ".join(
                f"{name} {'for at most' if over == 'violation' else 'by'} {number(due.by)}{_times(due.weight)}"
                for name, due in deadlines.items()
            )
            return f"The preference adds up by how much each task {what} beyond its limit: {limits}."
        case Expression(expression, _, over):
            what = "what is paid to relax it" if over == "violation" else "what is spent until it is done"
            return f"The preference is {expression}, where a task's name stands for {what}."
        case Sum(parts):
            words = [f"({i}){_times(weight)} {in_words(part, tasks)}" for i, (part, weight) in enumerate(parts, 1)]
            return f"The preference is the sum of {len(parts)} parts. {' '.join(words)}"
    return "The preference is a function of what is spent until each task is done."


def wishes(preference: Preference, plan: Plan) -> tuple[Wish, ...]:
    """Return what a preference wishes of the tasks, and how a plan falls short of it.

    The amounts add up to the preference; where it is not a sum over tasks, nothing is returned.
    """
    costs = {name: exact(cost) for name, cost in plan.task_costs.items()}
    paid = {name: exact(cost) for name, cost in plan.violation_costs.items()}
    found = _wishes(preference, costs, paid)
    return () if found is None else tuple(found)


def _wishes(preference: Preference, costs: dict[str, Fraction], paid: dict[str, Fraction]) -> list[Wish] | None:
    match preference:
        case Order(order):
            return _places(order or tuple(costs), costs)
        case WeightedSum(weights, over):
            amounts = paid if over == "violation" else costs
            words = "not relaxed" if over == "violation" else "early"
            return [
                Wish(name, words + _times(weight), None, to_number(exact(weight) * amounts[name]))
                for name, weight in weights.items()
            ]
        case Deadline(deadlines, over):
            amounts = paid if over == "violation" else costs
            words = "for at most" if over == "violation" else "by"
            found = []
            for name, due in deadlines.items():
                missed = max(Fraction(0), amounts[name] - exact(due.by))
                adds = to_number(exact(due.weight) * missed)
                found.append(Wish(name, f"{words} {number(due.by)}{_times(due.weight)}", to_number(missed), adds))
            return found
        case Sum(parts):
            together: list[Wish] = []
            for part, weight in parts:
                some = _wishes(part, costs, paid)
                if some is None:
                    return None
                times = exact(weight)
                together += [replace(wish, adds=to_number(times * exact(wish.adds))) for wish in some]
            return together
    return None


def _places(order: Sequence[str | tuple[str, ...]], costs: dict[str, Fraction]) -> list[Wish]:
    """Return how late each task comes for its place; members of a group take its places as they come."""
    times, place, found = sorted(costs.values()), 0, []
    for entry in order:
        members = [entry] if isinstance(entry, str) else sorted(entry, key=lambda name: costs[name])
        last = place + len(members) - 1
        words = ordinal(place) if last == place else f"{ordinal(place)} to {ordinal(last)}"
        for name in members:
            missed = to_number(max(Fraction(0), costs[name] - times[place]))
            found.append(Wish(name, words, missed, missed))
            place += 1
    return found


def _either(names: Sequence[str]) -> str:
    return f"{', '.join(names[:-1])} and {names[-1]} in any order" if len(names) > 1 else names[0]


def _weighted(weights: object) -> str:
    pairs = dict(weights or {})  # type: ignore[call-overload]
    return " + ".join(name if exact(w) == 1 else f"{number(w)} × {name}" for name, w in pairs.items() if exact(w) != 0)


def _times(weight: Number) -> str:
    return "" if exact(weight) == 1 else f" (weight {number(weight)})"
