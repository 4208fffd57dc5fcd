"""The exact front of a small problem with rules, by exhaustive search; bad prefixes are watched."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from itertools import count, product
from typing import NamedTuple

from judge.enumerate import DONE, SKIPPED, readings
from judge.preferences import Mu, Number
from judge.problems import GraphProblem
from judge.semantics import Label, monitor
from judge.syntax import Formula

GONE = -3
"""In place of a monitor's state: the rule was broken, and paid for."""


class JudgedRule(NamedTuple):
    """A rule; `bad` is what its bad prefixes satisfy, and `skip` what breaking it costs, None if it may not be."""

    name: str
    bad: Formula
    skip: Number | None = None


def front_with_rules(
    problem: GraphProblem, rules: Sequence[JudgedRule], mu: Mu, *, max_cost: Number
) -> list[tuple[Number, Number]]:
    """Return the non-dominated (cost, mu) of cost at most `max_cost`, by rising cost.

    Args:
        problem: without the rules.
        rules: what no plan breaks, or only for a price.
        mu: of the costs and violation costs of the tasks and then of the rules; it falls in none of them.
        max_cost: greatest total cost, inclusive.
    """
    tasks, ticket = problem.tasks, count()
    seen, heap = set(), []

    def enter(g: Number, state: str, before: tuple, frozen: tuple, paid: tuple) -> None:
        for after, prices in _read(problem, rules, before, problem.label(state)):
            costs = tuple(g if c is None and q == DONE else c for c, q in zip(frozen, after, strict=False))
            spent = tuple(x + y for x, y in zip(paid, prices, strict=True))
            if g <= max_cost and (g, state, after, costs, spent) not in seen:
                seen.add((g, state, after, costs, spent))
                heapq.heappush(heap, (g, next(ticket), state, after, costs, spent))

    watching = tuple(monitor(rule.bad).start for rule in rules)
    for skipped in product(*([False] if task.skip is None else [False, True] for task in tasks)):
        begun = (SKIPPED if skip else monitor(task.formula).start for task, skip in zip(tasks, skipped, strict=True))
        paid = (*(task.skip if skip else 0 for task, skip in zip(tasks, skipped, strict=True)), *(0 for _ in rules))
        enter(0, problem.start, (*begun, *watching), (None,) * len(tasks), paid)
    front: list[tuple[Number, Number]] = []
    while heap:
        g, _, state, states, frozen, paid = heapq.heappop(heap)
        worth = mu((*(g if c is None else c for c in frozen), *(0 for _ in rules)), paid)
        if front and worth >= front[-1][1]:
            continue
        if all(q < 0 for q in states[: len(tasks)]):
            if front and front[-1][0] == g:
                front.pop()
            front.append((g, worth))
            continue
        for edge in problem.outgoing.get(state, []):
            enter(g + edge.cost, edge.target, states, frozen, paid)
    return front


def _read(
    problem: GraphProblem, rules: Sequence[JudgedRule], states: Sequence[int], label: Label
) -> Iterator[tuple[tuple[int, ...], tuple[Number, ...]]]:
    """Yield the states of tasks and rules after each way to read a label, and the prices."""
    options: list[list[tuple[int, Number]]] = [
        [(after, sum(price for _, price in bought)) for after, bought in readings(task, state, label).items()]
        for task, state in zip(problem.tasks, states, strict=False)
    ]
    for rule, state in zip(rules, states[len(problem.tasks) :], strict=True):
        after = state if state == GONE else monitor(rule.bad).step(state, label)
        broken = after != GONE and monitor(rule.bad).satisfied(after)
        options.append([(after, 0)] if not broken else [] if rule.skip is None else [(GONE, rule.skip)])
    for chosen in product(*options):
        yield tuple(state for state, _ in chosen), tuple(price for _, price in chosen)
