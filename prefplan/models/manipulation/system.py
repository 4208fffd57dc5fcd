"""A manipulation model as a transition system whose states are generated on demand."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property

from prefplan.errors import ModelError
from prefplan.models.generated import GeneratedSystem
from prefplan.models.manipulation.codes import StateCodes
from prefplan.models.manipulation.description import Description
from prefplan.models.manipulation.operators import STANDARD_OPERATORS, Operator, parameters_of
from prefplan.models.manipulation.quotient import ReducedModel, most_states
from prefplan.models.manipulation.state import ManipulationState
from prefplan.models.manipulation.state_space import Generator, reachable
from prefplan.models.transition_system import Barred, EdgeCosts, Quotient, TransitionSystem


class ManipulationSystem(GeneratedSystem):
    """The states reachable from one state of a manipulation model, numbered as they are met.

    Attributes:
        generator: generates the successors.
        first: the first state.
        barred: actions that do not exist where some propositions hold.
        listed_states: how many states may be listed, by an upper bound of their number.
    """

    generator: Generator
    first: ManipulationState
    barred: Barred
    listed_states: int

    def __init__(
        self, model: Description, operators: Sequence[Operator], start: ManipulationState, listed_states: int
    ) -> None:
        """Take the model, the kinds of actions, the first state, and `listed_states`.

        Raises:
            ModelError: the start is not a state of the model, or a state does not fit an integer.
        """
        space = StateCodes(model, start)
        self._codes = [space.encode(start, where="start")]
        generator = Generator.of(space, operators)
        super().__init__(
            start=0,
            unit=generator.costs[0].unit,
            cost_name=generator.costs[0].name,
            propositions=model.own_propositions | model.propositions,
            resolution=None,
            display=replace(model.display, parameters=parameters_of(operators)),
            generator=generator,
            first=start,
            barred=(),
            listed_states=listed_states,
        )
        unknown = generator.has_gaps and not self.is_large
        if unknown or generator.operators != STANDARD_OPERATORS:
            # Only listing all states shows whether every successor is a state, and every possible action was measured;
            # in a large model, the search reports an action that was not measured when it meets one.
            self.__dict__["listed"] = reachable(generator, self._codes)

    @cached_property
    def listed(self) -> TransitionSystem:
        """All states; those met before keep their numbers."""
        return reachable(self.generator, self._codes).without(self.barred).knowing(self.propositions)

    @cached_property
    def is_large(self) -> bool:
        """Whether listing all states may take long."""
        return most_states(self.generator.space) > self.listed_states

    @property
    def cost_names(self) -> tuple[str, ...]:
        """See `TransitionSystem.cost_names`."""
        return tuple(matrix.name for matrix in self.generator.costs)

    @property
    def more_costs(self) -> tuple[EdgeCosts, ...]:  # type: ignore[override]
        """See `TransitionSystem`; all states are listed for them."""
        return self.listed.more_costs if len(self.generator.costs) > 1 else ()

    @property
    def shared_units(self) -> tuple[Fraction, ...]:
        """See `TransitionSystem.shared_units`; here for all costs that an action may have, reachable or not."""
        return tuple(matrix.shared_unit for matrix in self.generator.costs)

    def with_first_cost(self) -> ManipulationSystem:
        """See `TransitionSystem.with_first_cost`."""
        return self._changed(generator=replace(self.generator, costs=self.generator.costs[:1]))

    def knowing(self, propositions: frozenset[str]) -> ManipulationSystem:
        """See `TransitionSystem.knowing`."""
        return self._changed(propositions=propositions)

    def without(self, barred: Barred) -> ManipulationSystem:
        """See `TransitionSystem.without`."""
        return self._changed(barred=(*self.barred, *barred))

    def _changed(self, **attributes: object) -> ManipulationSystem:
        other = object.__new__(ManipulationSystem)
        kept = {name: value for name, value in self.__dict__.items() if name != "listed"}
        other.__dict__.update(kept | {"_codes": list(self._codes)} | attributes)
        return other

    def state(self, number: int) -> ManipulationState:
        """Return the state with a number."""
        if not 0 <= number < len(self._codes):
            return self.listed.states[number]  # type: ignore[return-value]
        return self.generator.space.decode(self._codes[number])

    def label(self, state: int) -> frozenset[str]:
        """See `TransitionSystem.label`."""
        return self.state(state).label

    def steps(self, state: int, action: str) -> tuple[int, tuple[Fraction, ...]]:
        """See `TransitionSystem.steps`."""
        if "listed" in self.__dict__:
            return self.listed.steps(state, action)
        barred = any(action == name and names <= self.label(state) for names, name in self.barred)
        found = None if barred else self.generator.step(self._codes[state], action)
        if found is None:
            raise ModelError(f"action {action!r} does not exist in state {self.states[state]!r}")
        return self._number(found[0]), found[1]

    def _number(self, code: int) -> int:
        if code not in self._codes:
            self._codes.append(code)
        return self._codes.index(code)

    def reduced(self, names: Collection[str], *, stutter_invariant: bool) -> ReducedModel | None:
        """Return a smaller model to search instead; None for a small model, or one with further operators."""
        if not self.is_large or self.generator.operators != STANDARD_OPERATORS:
            return None
        return ReducedModel(self.generator, self.first, self.barred, names, stutter_invariant=stutter_invariant)

    def quotient(self, names: Collection[str], *, stutter_invariant: bool) -> Quotient:
        """See `TransitionSystem.quotient`; for a small model, the system with all states listed."""
        smaller = self.reduced(names, stutter_invariant=stutter_invariant)
        if smaller is None:
            return self.listed.quotient(names, stutter_invariant=stutter_invariant)
        quotient = smaller.quotient()
        return replace(quotient, system=quotient.system.knowing(self.propositions))
