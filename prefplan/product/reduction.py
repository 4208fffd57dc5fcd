"""The product that is searched for a problem: of its system, or of a smaller one, whose paths are lifted to it."""

from __future__ import annotations

import time
from functools import cached_property

import numpy as np

from prefplan.models.manipulation.system import ManipulationSystem
from prefplan.models.system import System, Trajectory
from prefplan.problem import Problem
from prefplan.product.generated_product import GeneratedProduct
from prefplan.product.product_automaton import Product


class Reduction:
    """A smaller system on which a problem's tasks read the same label sequences.

    Attributes:
        problem: the problem.
        build_seconds: time to build its product, s.
    """

    def __init__(self, problem: Problem) -> None:
        """Take a problem."""
        self.problem, self.build_seconds = problem, 0.0

    @cached_property
    def system(self) -> System:
        """The smaller system."""
        return self.problem.system.reduced(
            self.problem.task_propositions, stutter_invariant=self.problem.stutter_invariant
        )

    @cached_property
    def product(self) -> Product:
        """The product of the smaller system and the problem's tasks."""
        began = time.perf_counter()
        product = self.product_of(self.problem)
        self.build_seconds = time.perf_counter() - began
        return product

    def product_of(self, problem: Problem) -> Product:
        """Return the product of the smaller system and the tasks of a problem over the same system."""
        if isinstance(self.system, ManipulationSystem) and GeneratedProduct.suits(problem, self.system):
            return GeneratedProduct(problem, self.system)
        return self.listed_product(problem)

    def listed_product(self, problem: Problem) -> Product:
        """Return the same, its states listed."""
        return ReducedProduct(problem, self.system) if isinstance(self.system, ManipulationSystem) else Product(problem)


class ReducedProduct(Product):
    """The product of a smaller system than the problem's own, with all its states listed."""

    def __init__(self, problem: Problem, smaller: ManipulationSystem) -> None:
        """Take a problem, and its smaller system."""
        super().__init__(problem.over(smaller.listed))
        self._whole, self._smaller = problem.system, smaller

    def trajectory(self, steps: np.ndarray) -> Trajectory:
        """Return what happens in the problem's own system along (K,) edges of the smaller one from the start on."""
        listed = self._smaller.listed
        codes = [
            self._smaller.space.encode(listed.states[state], where="state")
            for state in [listed.start, *listed.targets[steps].tolist()]
        ]
        return self._whole.trajectory(self._smaller.actions_through(codes))
