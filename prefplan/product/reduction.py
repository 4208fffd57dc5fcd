"""The product that is searched for a problem: of its system, or of a smaller one, whose paths are lifted to it."""

from __future__ import annotations

import time
from functools import cached_property

import numpy as np

from prefplan.models.manipulation.system import ManipulationSystem
from prefplan.models.system import Quotient
from prefplan.problem import Problem
from prefplan.product.generated_product import GeneratedProduct
from prefplan.product.product_automaton import Product, Trajectory


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
    def quotient(self) -> Quotient:
        """The smaller system, listed."""
        return self.problem.system.quotient(
            self.problem.task_propositions, stutter_invariant=self.problem.stutter_invariant
        )

    @cached_property
    def model(self) -> ManipulationSystem | None:
        """The smaller system, unless its states are listed."""
        system = self.problem.system
        if not isinstance(system, ManipulationSystem):
            return None
        return system.reduced(self.problem.task_propositions, stutter_invariant=self.problem.stutter_invariant)

    @cached_property
    def product(self) -> Product:
        """The product of the smaller system and the problem's tasks."""
        began = time.perf_counter()
        product = self.product_of(self.problem)
        self.build_seconds = time.perf_counter() - began
        return product

    def product_of(self, problem: Problem) -> Product:
        """Return the product of the smaller system and the tasks of a problem over the same system."""
        if self.model is not None and GeneratedProduct.suits(problem, self.model):
            return GeneratedProduct(problem, self.model)
        return self.listed_product(problem)

    def listed_product(self, problem: Problem) -> Product:
        """Return the same, its states listed."""
        return Product(problem) if self.quotient.system is problem.system else QuotientProduct(problem, self.quotient)


class QuotientProduct(Product):
    """The product of a smaller system than the problem's own."""

    def __init__(self, problem: Problem, quotient: Quotient) -> None:
        """Take a problem, and the quotient of its system."""
        super().__init__(problem.over(quotient.system))
        self._whole, self._lift = problem.system, quotient.lift

    def trajectory(self, steps: np.ndarray) -> Trajectory:
        """Return what happens in the problem's own system along (K,) edges of the smaller one from the start on."""
        actions, states = self._lift(super().trajectory(steps)[:2])
        return actions, states, *self._whole.along(actions)
