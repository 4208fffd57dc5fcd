"""Smaller models of a manipulation model, equivalent for the propositions in a given set, which are called *seen*.

Two reductions, both exact:

*Symmetry.* A location of capacity one that no other location depends on and no seen proposition mentions is *neutral*
(with measured costs, which tell locations but not objects apart, no location is). Exchanging neutral locations, or
movable *unseen* objects, which no seen proposition mentions, maps the model onto itself and preserves costs and seen
propositions. So one canonical state can stand for all states that such exchanges make of it (its orbit), and the
canonical states are a bisimulation quotient: every trajectory of the one has its counterpart in the other, action by
action. (E. A. Emerson and A. P. Sistla, "Symmetry and model checking", 1996.)

*Relevance.* A movable unseen object at a neutral location need never be moved, if the other neutral locations can hold
all other movable objects at once, and no seen location rests on supports: in any plan, leave out the actions on it, and
put every object that the plan puts at a neutral location at a free one. One is free, as the object in the hand takes
none; costs do not depend on the location, so no action of the plan gets dearer. The actions left out change no seen
proposition; so this needs tasks that do not count actions, and preferences that do not gain from waiting. By the same
argument no more neutral locations are needed than there are movable objects.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import cached_property
from math import comb, perm

from prefplan.models.costs import amount
from prefplan.models.manipulation.action import at, marked
from prefplan.models.manipulation.action_costs import ActionCosts, MeasuredCosts, cost_names
from prefplan.models.manipulation.codes import StateCodes
from prefplan.models.manipulation.description import Description, Location
from prefplan.models.manipulation.listing import ActionModel, listed, moves_of, table
from prefplan.models.manipulation.operators import read_action
from prefplan.models.manipulation.slots import hand_poses
from prefplan.models.manipulation.state import ManipulationState
from prefplan.models.manipulation.successors import Moves, canonical
from prefplan.models.system import Barred, Quotient, Trajectory


def most_states(model: Description, start: ManipulationState) -> int:
    """Return an upper bound of the number of states of a model, not counting marks."""
    slots = model.slot_counts
    capacities = [(place.capacity, slots[place.name]) for place in model.locations]
    movable = sum(not obj.fixed for obj in model.objects)

    def placements(count: int) -> int:
        """Return the number of ways to spread a number of objects over the locations, or their slots."""
        number = [1] + [0] * count
        for capacity, apart in capacities:
            orders = [perm(apart, k) if apart > 1 else 1 for k in range(capacity + 1)]
            number = [
                sum(number[n - k] * comb(n, k) * orders[k] for k in range(min(capacity, n) + 1))
                for n in range(count + 1)
            ]
        return number[count]

    held = movable * placements(movable - 1) if movable else 0
    return len(hand_poses(slots, slots.values(), start.hand)) * (placements(movable) + held)


class Symmetry:
    """A model, and which of its parts are seen.

    Attributes:
        model: the model.
        neutral: names of the neutral locations, in the model's order.
        unseen: names of the movable objects of which nothing is seen.
    """

    def __init__(
        self, model: Description, seen: frozenset[str], told: frozenset[str], *, places_alike: bool = True
    ) -> None:
        """Find the neutral locations and the unseen objects.

        Args:
            model: the model.
            seen: the propositions that are seen.
            told: names of objects and locations that count as seen for another reason.
            places_alike: whether locations may be neutral; False if costs tell them apart.
        """
        self.model, self._seen, self._told = model, seen, told
        self._objects = [obj.name for obj in model.objects]
        supports = {support for place in model.locations for support in (*place.on, *place.clear_of)}
        self.neutral = [
            place.name
            for place in (model.locations if places_alike else ())
            if place.capacity == 1 and not (place.on or place.clear_of or place.closed)
            if place.name not in supports and not self._sees(place)
        ]
        self.unseen = [
            obj.name
            for obj in model.objects
            if not obj.fixed and obj.name not in told and not seen & {n for n, _ in model.propositions_of(obj.name)}
        ]

    def sees_mark(self, obj: str, mark: str) -> bool:
        """Return whether the proposition that an object has a mark is seen."""
        return marked(obj, mark) in self._seen

    def _sees(self, place: Location) -> bool:
        marks = {marked(obj, place.marks) for obj in self._objects} if place.marks else set()
        return place.name in self._told or bool(self._seen & ({at(obj, place.name) for obj in self._objects} | marks))

    def relevant(self, start: ManipulationState) -> tuple[Symmetry, ManipulationState]:
        """Return the same, and the initial state, without objects that need never be moved and surplus locations."""
        model, places = self.model, start.place
        if any(place.on and self._sees(place) for place in model.locations):
            return self, start
        idle = {obj for obj in self.unseen if places.get(obj) in self.neutral}
        idle |= {obj.name for obj in model.objects if obj.fixed and obj.name not in self._told} & {
            obj for obj in self._objects if places.get(obj) in self.neutral
        }
        blocked = {places[obj] for obj in idle}
        free = [place for place in self.neutral if place not in blocked]
        movable = [obj for obj in model.objects if not obj.fixed and obj.name not in idle]
        if len(free) < len(movable):
            return self, start
        taken = [place for place in free if place in places.values()]
        spare = [place for place in free if place not in taken]
        wanted = {*taken, *spare[: len(movable) - len(taken)]}
        kept = tuple(p for p in model.locations if p.name not in self.neutral or p.name in wanted)
        if not kept:
            return self, start
        objects = tuple(
            replace(obj, start=places.get(obj.name, kept[0].name)) for obj in model.objects if obj.name not in idle
        )
        left = {place.marks for place in kept}
        begin = replace(
            start,
            places=tuple((obj, place) for obj, place in start.places if obj not in idle),
            marks=frozenset((obj, mark) for obj, mark in start.marks if obj not in idle and mark in left),
        )
        assert {place for _, place in begin.places} <= {place.name for place in kept}
        smaller = replace(model, locations=kept, objects=objects, begin=begin)
        return Symmetry(smaller, self._seen, self._told), begin


class ReducedModel:
    """A smaller model that is equivalent to another for the propositions that are seen.

    Attributes:
        symmetry: the smaller model, and which of its parts may be exchanged.
        actions: the actions of the smaller model.
        start: its initial state.
        seen: the propositions that are seen.
        barred: actions that do not exist where some propositions hold.
    """

    def __init__(
        self,
        whole: ActionModel,
        start: ManipulationState,
        barred: Barred,
        names: Collection[str],
        *,
        stutter_invariant: bool,
    ) -> None:
        """Make a model smaller.

        Args:
            whole: the actions of the other model.
            start: its initial state.
            barred: actions that do not exist where some propositions hold.
            names: the propositions that are seen.
            stutter_invariant: as in `System.quotient`.
        """
        self._whole, self._whole_start, self.barred = whole, start, barred
        model = whole.space.model
        self.seen = frozenset(names).union(*(conditions for conditions, _ in barred))
        actions = [read_action(text) for _, text in barred]
        told = frozenset(name for action in actions for name in (action.obj, action.location))
        alike = not isinstance(model.costs, MeasuredCosts)
        symmetry = Symmetry(model, self.seen, told, places_alike=alike)
        if stutter_invariant and not barred and _loads_cost(model.costs):
            symmetry, start = symmetry.relevant(start)
        self.symmetry, self.start = symmetry, start
        space = StateCodes(symmetry.model, start, symmetry.sees_mark)
        hands = [whole.space.hands.index(hand) for hand in space.hands]
        costs = tuple(matrix.between(hands) for matrix in whole.costs)
        self.actions = ActionModel(space, whole.operators, costs)

    @property
    def space(self) -> StateCodes:
        """The encoding of its states."""
        return self.actions.space

    @cached_property
    def moves(self) -> Moves:
        """The smaller model as arrays; its codes must be small."""
        return moves_of(self.space, self.symmetry.neutral, self.symmetry.unseen)

    @property
    def first(self) -> int:
        """The code of the canonical state of `start`.

        Raises:
            ModelError: there are too many states for 64-bit integers.
        """
        self.space.require_small()
        return self._canonical(self.start)

    def _canonical(self, state: ManipulationState) -> int:
        return int(canonical(self.moves, self.space.encode(state, where="state")))

    def require_measured(self, code: int) -> None:
        """Raise ModelError if the cost of some action of a state was not measured."""
        self.actions.require_measured(self.space.decode(code))

    def quotient(self) -> Quotient:
        """Return the canonical states, listed."""
        system = table(self.space, listed(self.space, self.moves, self.first), self.actions.costs, self.seen)

        def lift(trajectory: Trajectory) -> Trajectory:
            return self.lift([self.space.encode(state, where="state") for state in trajectory[1]])  # type: ignore[arg-type]

        return Quotient(system.without(self.barred), lift)

    def lift(self, codes: Sequence[int]) -> Trajectory:
        """Return the trajectory of the other model that corresponds to one through canonical states, given by codes."""
        state, actions = self.space.decode(self.space.encode(self.start, where="start")), list[str]()
        for wanted in codes[1:]:
            # The successor determines the action's kind and the poses of the hand, and so its cost.
            action, state = next(each for each in self.actions.of(state) if self._canonical(each[1]) == wanted)
            actions.append(str(action))
        states = [self._whole_start]
        for text in actions:
            states.append(next(after for action, after in self._whole.of(states[-1]) if str(action) == text))
        return tuple(actions), tuple(states)


def _loads_cost(costs: ActionCosts) -> bool:
    """Return whether costs do not depend on locations, and a transport costs at least as much as a transit."""
    if isinstance(costs, MeasuredCosts):
        return False
    return all(amount(costs["transit"], name) <= amount(costs["transport"], name) for name in cost_names(costs))
