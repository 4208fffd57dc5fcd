"""Automata of tasks that also monitor rules: they go to their dead state when a rule is broken.

A plan ends when the last task is satisfied, and until then that task's automaton monitors the rules. So no other
automaton is needed to keep every rule along the whole plan.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial

from prefplan.logic.dfa import Automaton
from prefplan.logic.mtbdd import Branch, Diagram, Diagrams, upwards

_ACCEPTING, _DEAD = "accepting", "dead"

APART = "'"
"""Suffix of a proposition that only rules read; it does not change the order of names."""


def watching(
    task: Automaton, modes: Sequence[Sequence[Automaton]], *, apart: frozenset[str]
) -> tuple[Automaton, tuple[int, ...]]:
    """Return a task's automaton that watches rules, and its initial state in each mode.

    Args:
        task: the task's automaton.
        modes: the automata of the bad prefixes of the monitored rules, by mode; the first mode starts in state 0.
        apart: propositions that the rules read under another name, with the suffix `APART`.
    """
    diagrams = Diagrams()
    pair = diagrams.lift(lambda states, rule: (*states, rule))
    numbers: dict[object, int] = {}
    queue: list[tuple[int, tuple[int, ...]] | str] = []

    def number(mode: int, states: tuple[int, ...]) -> int:
        rules = zip(states[1:], modes[mode], strict=True)
        broken = any(state == rule.accepting for state, rule in rules)
        ended = _DEAD if broken or states[0] == task.dead else _ACCEPTING if states[0] == task.accepting else None
        state = ended or (mode, states)
        if state not in numbers:
            numbers[state] = len(queue)
            queue.append(state)
        return numbers[state]

    initial = tuple(number(mode, (0,) * (1 + len(rules))) for mode, rules in enumerate(modes))
    transitions: list[Diagram] = []
    for at, state in enumerate(queue):
        if isinstance(state, str):
            transitions.append(at)
            continue
        mode, states = state
        after = diagrams.map(task.transitions[states[0]], lambda q: (q,))
        for rule, q in zip(modes[mode], states[1:], strict=True):
            after = pair(after, _renamed(rule.transitions[q], apart, diagrams))
        transitions.append(diagrams.map(after, partial(number, mode)))
    names = {name + APART * (name in apart) for rules in modes for rule in rules for name in rule.propositions}
    propositions = tuple(sorted(names.union(task.propositions)))
    accepting, dead = numbers.get(_ACCEPTING), numbers.get(_DEAD)
    return Automaton(task.text, propositions, tuple(transitions), accepting, dead), initial


def told_apart(label: frozenset[str], apart: Iterable[str]) -> frozenset[str]:
    """Return a label in which the propositions in `apart` also hold under the names that rules read."""
    return label | {name + APART for name in apart if name in label}


def _renamed(diagram: Diagram, apart: frozenset[str], diagrams: Diagrams) -> Diagram:
    found: dict[Diagram, Diagram] = {}
    for d in upwards(diagram):
        found[d] = d
        if isinstance(d, Branch):
            found[d] = diagrams.branch(d.name + APART * (d.name in apart), found[d.high], found[d.low])
    return found[diagram]
