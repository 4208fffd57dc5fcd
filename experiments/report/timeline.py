"""What a plan or a run comes to, action by action: what is spent, and where every task's automaton stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from prefplan.exact_costs import Number, exact, to_number
from prefplan.front import Plan, Purchase
from prefplan.problem import Problem

Label = frozenset[str]


@dataclass(frozen=True)
class Track:
    """A task along K actions.

    Attributes:
        states: (K + 1,) state of its automaton after k actions and the reading that follows; None if it is skipped.
        satisfied: after how many actions it is satisfied, or None.
        bought: its relaxations that are used.
    """

    states: tuple[int, ...] | None
    satisfied: int | None
    bought: tuple[Purchase, ...] = ()

    @property
    def advances(self) -> tuple[int, ...]:
        """After how many actions its automaton has just moved on, the start's reading left out."""
        states = self.states or ()
        return tuple(k for k in range(1, len(states)) if states[k] != states[k - 1])


@dataclass(frozen=True)
class Timeline:
    """K actions and what they come to.

    Attributes:
        actions: (K,) in order.
        costs: (K,) of each.
        labels: (K + 1,) what holds at the start and after every action.
        tracks: by task name.
    """

    actions: tuple[str, ...]
    costs: tuple[Number, ...]
    labels: tuple[Label, ...]
    tracks: dict[str, Track]

    @property
    def spent(self) -> tuple[int | float, ...]:
        """(K + 1,) spent after k actions."""
        total, found = Fraction(0), [Fraction(0)]
        for cost in self.costs:
            total += exact(cost)
            found.append(total)
        return tuple(map(to_number, found))

    @property
    def order(self) -> tuple[str, ...]:
        """The tasks that are satisfied, in the order in which they are; ties as in the scenario."""
        done = [(track.satisfied, name) for name, track in self.tracks.items() if track.satisfied is not None]
        return tuple(name for _, name in sorted(done, key=lambda pair: pair[0]))


def plan_timeline(problem: Problem, plan: Plan) -> Timeline:
    """Return what a plan comes to, by the model.

    Raises:
        ModelError: an action does not exist where the plan has it.
    """
    system = problem.system
    state, costs, labels = system.start, [], [system.label(system.start)]
    for action in plan.actions:
        state, cost = system.step(state, action)
        costs.append(cost)
        labels.append(system.label(state))
    return timeline(problem, plan.actions, costs, labels, plan.relaxations)


def timeline(
    problem: Problem,
    actions: Sequence[str],
    costs: Sequence[Number],
    labels: Sequence[Label],
    relaxations: Sequence[Purchase],
) -> Timeline:
    """Return what actions come to, each task's automaton reading the labels as the relaxations allow.

    Args:
        problem: the tasks.
        actions: (K,) what is done.
        costs: (K,) of each action.
        labels: (K + 1,) what holds at the start and after every action.
        relaxations: what is bought.
    """
    tracks = {}
    for task, automaton in zip(problem.tasks, problem.automata, strict=True):
        bought = tuple(one for one in relaxations if one.task == task.name)
        if any(one.assume is None for one in bought):
            tracks[task.name] = Track(None, None, bought)
            continue
        state, states = 0, []
        for k, label in enumerate(labels):
            state = automaton.step(state, label | {one.assume for one in bought if one.assume and one.step == k})
            states.append(state)
        done = states.index(automaton.accepting) if automaton.accepting in states else None
        tracks[task.name] = Track(tuple(states), done, bought)
    return Timeline(tuple(actions), tuple(costs), tuple(labels), tracks)
