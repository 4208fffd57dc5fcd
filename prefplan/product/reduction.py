"""The product that is searched for a problem: of its system, or of a smaller one, whose paths are lifted to it.

The smaller system of a manipulation model is listed, or its states are generated from packed integers. If they are
generated, each automaton has its own alphabet: a letter is a number, the sum of what the digits of a state contribute
to the automaton's propositions.
"""

import math
from collections.abc import Sequence

import numpy as np

from prefplan.exact_costs import INT64_LIMIT
from prefplan.models.manipulation.successors import steps_of
from prefplan.models.manipulation.system import ManipulationSystem
from prefplan.problem import Problem
from prefplan.product.product_automaton import Product
from prefplan.product.space import Generated, Graph

LETTERS_LIMIT = 2**14
"""Most pairs of a state and a letter of one automaton that are tabulated."""


def product_of(problem: Problem) -> Product:
    """Return the product of a problem's tasks and its system, or a smaller one on which they read the same labels."""
    if problem.system.small is not None:
        return Product(problem)
    assert isinstance(problem.system, ManipulationSystem)
    smaller = problem.system.reduced(problem.task_propositions, stutter_invariant=problem.stutter_invariant)
    return (GeneratedProduct if GeneratedProduct.suits(problem, smaller) else ReducedProduct)(problem, smaller)


class ReducedProduct(Product):
    """The product of a smaller system than the problem's own, with all its states listed."""

    def __init__(self, problem: Problem, smaller: ManipulationSystem) -> None:
        """Take a problem, and its smaller system."""
        super().__init__(problem.over(smaller.listed))
        self.system, self._smaller = problem.system, smaller

    def actions(self, steps: np.ndarray) -> Sequence[str]:
        """Return the actions in the problem's own system of a path of (K,) edges of the smaller one from the start."""
        listed, space = self.listed, self._smaller.space
        states = [listed.start, *listed.targets[steps].tolist()]
        return self._smaller.actions_through([space.encode(listed.states[state], where="state") for state in states])


class GeneratedProduct(Product):
    """T x A_1 x ... x A_N, of a model T whose states are never listed.

    The `graph` has no nodes and edges; its costs are (4 H H,), by price, as in
    `prefplan.models.manipulation.successors.Steps`.

    Attributes:
        model: the model.
    """

    def __init__(self, problem: Problem, model: ManipulationSystem) -> None:
        """Tabulate every automaton over its letters; call `suits` before."""
        self.problem, self.system, self.model = problem, problem.system, model
        self.automata, self.followers, self.nodes = problem.weighted_automata, problem.followers, model.space.bound
        costs, *self.more_costs = (c.counts(unit) for c, unit in zip(model.costs, problem.cost_units, strict=True))
        self.generated = Generated(model.moves, costs, self._tabulate_letters(), steps_of(model.moves))
        none, start = np.zeros(0, dtype=np.int32), model.canonical(model.start)
        self.graph = Graph(np.zeros(1, dtype=np.int64), none, costs, none, none, start, False, 0)

    @staticmethod
    def suits(problem: Problem, model: ManipulationSystem) -> bool:
        """Return whether a product can be generated: no task can be relaxed, and all tables and numbers are small."""
        states = model.space.bound * math.prod(dfa.size for dfa in problem.followers)
        if states >= INT64_LIMIT or any(task.relax for task in problem.tasks):
            return False
        counts = [
            dfa.size * math.prod(len(set(values)) for _, values in model.space.visible(dfa.propositions))
            for dfa in problem.followers
        ]
        greatest = max(each.greatest / unit for each, unit in zip(model.costs, problem.cost_units, strict=True))
        return max(counts) <= LETTERS_LIMIT and greatest < INT64_LIMIT

    def actions(self, steps: np.ndarray) -> Sequence[str]:
        """Return actions that lead through (K,) states of the model after the start."""
        return self.model.actions_through([self.graph.start, *steps.tolist()])

    def _tabulate_letters(self) -> np.ndarray:
        """Fill the automata's tables, and return (N + R, D, r) what each value of a digit adds to a letter."""
        space = self.model.space
        letters = np.zeros((len(self.followers), len(space.radices), max(space.radices)), dtype=np.int64)
        labels: list[list[frozenset[str]]] = []
        for i, dfa in enumerate(self.followers):
            labels_of = [frozenset[str]()]
            for d, values in space.visible(dfa.propositions):
                distinct = list(dict.fromkeys(values))
                letters[i, d, : len(values)] = [len(labels_of) * distinct.index(value) for value in values]
                labels_of = [label | ({value} if value else set()) for value in distinct for label in labels_of]
            labels.append(labels_of)
        self._enter(
            [
                [tuple(tuple(dfa.readings(q, label)) for q in range(dfa.size)) for label in labels_of]
                for dfa, labels_of in zip(self.followers, labels, strict=True)
            ]
        )
        return letters
