"""Product automaton (Definition 7), never built: states are made as the search asks for them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from prefplan.problem import Problem

State = tuple[int, ...]
"""(s, q_1, ..., q_N): a state of the transition system and one of each task's automaton."""


class Product:
    """T x A_1 x ... x A_N, by successors.

    Attributes:
        problem: what it is made from.
        delta: per task, (Q_i, labels) state of A_i after reading each of the system's distinct labels.
        start: p_0, after the automata have read L(s0).
    """

    def __init__(self, problem: Problem) -> None:
        """Tabulate each automaton over the labels that occur."""
        self.problem = problem
        system = problem.system
        self.delta: tuple[list[list[int]], ...] = tuple(
            [[dfa.step(q, label) for label in system.label_sets] for q in range(dfa.size)] for dfa in problem.automata
        )
        self.accepting = tuple(dfa.accepting for dfa in problem.automata)
        scale = 10 ** (problem.decimals - system.decimals)
        self._edges = list(zip(system.targets.tolist(), (system.costs * np.int64(scale)).tolist(), strict=True))
        self._offsets = system.offsets.tolist()
        self._labels = system.labels.tolist()
        label = self._labels[system.start]
        self.start: State = (system.start, *(table[0][label] for table in self.delta))

    def successors(self, state: State) -> Iterator[tuple[int, int, State]]:
        """Yield (edge of the system, cost in quanta, p') for every action, in the model's order."""
        s, *automata = state
        for edge in range(self._offsets[s], self._offsets[s + 1]):
            target, cost = self._edges[edge]
            label = self._labels[target]
            after = tuple([table[q][label] for table, q in zip(self.delta, automata, strict=True)])
            yield edge, cost, (target, *after)

    def satisfied(self, state: State) -> tuple[bool, ...]:
        """Return acc(p): for each task, whether it is satisfied."""
        return tuple([q == goal for q, goal in zip(state[1:], self.accepting, strict=True)])
