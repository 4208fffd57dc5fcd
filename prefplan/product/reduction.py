"""The product that is searched for a problem: of its system, or of a smaller one, whose paths are lifted to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from prefplan.models.manipulation.system import ManipulationSystem
from prefplan.problem import Problem
from prefplan.product.generated_product import GeneratedProduct
from prefplan.product.product_automaton import Product


@dataclass
class Reduction:
    """A smaller system on which a problem's tasks read the same label sequences, and products of it.

    A system whose states are listed stays as it is.
    """

    problem: Problem

    @cached_property
    def product(self) -> Product:
        """The product of the smaller system and the problem's tasks."""
        return self.product_of(self.problem)

    def product_of(self, problem: Problem, *, listed: bool = False) -> Product:
        """Return the product for another problem over the same system; its states are listed if need be, or at will."""
        if not isinstance(problem.system, ManipulationSystem):
            return Product(problem)
        if not listed and GeneratedProduct.suits(problem, self._smaller):
            return GeneratedProduct(problem, self._smaller)
        return ReducedProduct(problem, self._smaller)

    @cached_property
    def _smaller(self) -> ManipulationSystem:
        whole, names = self.problem.system, self.problem.task_propositions
        assert isinstance(whole, ManipulationSystem)
        return whole.reduced(names, stutter_invariant=self.problem.stutter_invariant)


class ReducedProduct(Product):
    """The product of a smaller system than the problem's own, with all its states listed."""

    def __init__(self, problem: Problem, smaller: ManipulationSystem) -> None:
        """Take a problem, and its smaller system."""
        super().__init__(problem.over(smaller.listed))
        self.system, self._smaller = problem.system, smaller

    def actions(self, steps: np.ndarray) -> Sequence[str]:
        """Return the actions in the problem's own system of a path of (K,) edges of the smaller one from the start."""
        listed, space = self._smaller.listed, self._smaller.space
        states = [listed.start, *listed.targets[steps].tolist()]
        return self._smaller.actions_through([space.encode(listed.states[state], where="state") for state in states])
