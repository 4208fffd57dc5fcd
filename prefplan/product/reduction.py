"""The quotient that is searched in place of a problem's system, and the lifting of its plans to the whole system."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from functools import cached_property

from prefplan.exact_costs import to_number
from prefplan.ledger import Ledger
from prefplan.models.manipulation.symmetry import ReducedModel
from prefplan.models.manipulation.system import ManipulationSystem
from prefplan.models.system import Quotient
from prefplan.plan import Plan
from prefplan.problem import Problem
from prefplan.product.generated_product import GeneratedProduct
from prefplan.product.product_automaton import Product


class Reduction:
    """A smaller system on which a problem's tasks read the same label sequences.

    Attributes:
        problem: the problem.
        build_seconds: time to build its product, s.
    """

    def __init__(self, problem: Problem, *, generated: bool) -> None:
        """Take a problem, and whether states of large manipulation models may be generated on demand."""
        self.problem, self._generated = problem, generated
        self.build_seconds = 0.0

    @cached_property
    def quotient(self) -> Quotient:
        """The smaller system, listed."""
        return self.problem.system.quotient(
            self.problem.task_propositions, stutter_invariant=self.problem.stutter_invariant
        )

    @cached_property
    def _model(self) -> ReducedModel | None:
        """The smaller system, unless its states are listed."""
        system = self.problem.system
        if not isinstance(system, ManipulationSystem) or not self._generated:
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
        if self._model is not None and GeneratedProduct.suits(problem, self._model):
            return GeneratedProduct(problem, self._model)
        return self.listed_product(problem)

    def listed_product(self, problem: Problem) -> Product:
        """Return the same, its states listed."""
        return Product(problem.over(self.quotient.system))

    def lifted(self, plan: Plan, searched: Product) -> Plan:
        """Return a plan of a product as a plan of the whole system, asserting that all its costs and values agree."""
        whole = plan
        if not isinstance(searched, GeneratedProduct):
            known = len(self.problem.past.actions)
            actions, states = self.quotient.lift((plan.actions[known:], plan.states[known:]))
            whole = replace(plan, actions=plan.actions[:known] + actions, states=plan.states[:known] + states)
        if whole.states is not plan.states or isinstance(searched, GeneratedProduct):
            ledger = Ledger.of_plan(self.problem, whole)
            whole = replace(whole, action_costs=tuple(map(to_number, ledger.costs)))
            worth = (*ledger.exact_objectives(), *ledger.final.task_costs.values())
            found_worth = (*whole.objectives.values(), *whole.task_costs.values())
            assert all(map(math.isclose, worth, found_worth)), "the plan is worth something else in the whole model"
        return whole
