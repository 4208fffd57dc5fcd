"""Smaller models of a manipulation model, equivalent for the propositions in a given set, which are called *visible*.

Two reductions, both exact:

*Symmetry.* A location of capacity one that no other location depends on and no visible proposition mentions is
*neutral* (with measured costs, which tell locations but not objects apart, no location is). Exchanging neutral
locations, or movable objects that are *alike*, as no visible proposition mentions them, maps the model onto itself and
preserves costs and visible propositions. So one canonical state can stand for all states that such exchanges make of it
(its orbit), and the canonical states are a bisimulation quotient: every trajectory of the one has its counterpart in
the other, action by action. (E. A. Emerson and A. P. Sistla, "Symmetry and model checking", 1996.)

*Relevance.* One of these objects that rests at a neutral location need never be moved, if the other neutral locations
can hold all other movable objects at once, and no visible location rests on supports: in any plan, leave out the
actions on it, and put every object that the plan puts at a neutral location at a free one. One is free, as the object
in the hand takes none; costs do not depend on the location, so no action of the plan gets dearer. The actions left out
change no visible proposition; so this needs tasks that do not count actions, and preferences that do not gain from
waiting. By the same argument no more neutral locations are needed than there are movable objects.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from math import comb, perm
from typing import TYPE_CHECKING

from prefplan.models.costs import amount
from prefplan.models.manipulation.action import at, marked
from prefplan.models.manipulation.action_costs import ActionCosts, MeasuredCosts, cost_names
from prefplan.models.manipulation.description import Location
from prefplan.models.manipulation.operators import read_action
from prefplan.models.manipulation.slots import hand_poses
from prefplan.models.manipulation.state import ManipulationState
from prefplan.models.system import Barred

if TYPE_CHECKING:
    from prefplan.models.manipulation.model import ManipulationModel


def most_states(model: ManipulationModel, start: ManipulationState) -> int:
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


def symmetry_of(
    model: ManipulationModel,
    start: ManipulationState,
    names: Collection[str],
    barred: Barred,
    *,
    stutter_invariant: bool,
) -> tuple[Symmetry, ManipulationState]:
    """Return a smaller model and its initial state, equivalent to another for the propositions that are visible.

    Args:
        model: the other model.
        start: its initial state.
        names: propositions that are visible, beside those on which barred actions depend.
        barred: actions that do not exist where some propositions hold.
        stutter_invariant: as in `System.quotient`.
    """
    visible = frozenset(names).union(*(conditions for conditions, _ in barred))
    actions = [read_action(text) for _, text in barred]
    named = frozenset(name for action in actions for name in (action.obj, action.location))
    symmetry = Symmetry(model, visible, named, places_alike=not isinstance(model.costs, MeasuredCosts))
    if stutter_invariant and not barred and _loads_cost(model.costs):
        return symmetry.relevant(start)
    return symmetry, start


class Symmetry:
    """A model, and which of its parts are visible.

    Attributes:
        model: the model.
        visible: the propositions that are visible.
        neutral: names of the neutral locations, in the model's order.
        alike: names of the movable objects of which nothing is visible, which may be exchanged.
    """

    def __init__(
        self, model: ManipulationModel, visible: frozenset[str], named: frozenset[str], *, places_alike: bool = True
    ) -> None:
        """Find the neutral locations and the invisible objects.

        Args:
            model: the model.
            visible: the propositions that are visible.
            named: names of objects and locations that count as visible for another reason.
            places_alike: whether locations may be neutral; False if costs tell them apart.
        """
        self.model, self.visible, self._named = model, visible, named
        self._objects = [obj.name for obj in model.objects]
        supports = {support for place in model.locations for support in (*place.on, *place.clear_of)}
        self.neutral = tuple(
            place.name
            for place in (model.locations if places_alike else ())
            if place.capacity == 1 and not (place.on or place.clear_of or place.closed)
            if place.name not in supports and not self._is_visible(place)
        )
        self.alike = tuple(
            obj.name
            for obj in model.objects
            if not obj.fixed and obj.name not in named and not visible & {n for n, _ in model.propositions_of(obj.name)}
        )

    def _is_visible(self, place: Location) -> bool:
        names = {at(obj, place.name) for obj in self._objects}
        names |= {marked(obj, place.marks) for obj in self._objects if place.marks}
        return place.name in self._named or not self.visible.isdisjoint(names)

    def relevant(self, start: ManipulationState) -> tuple[Symmetry, ManipulationState]:
        """Return the same, and the initial state, without objects that need never be moved and surplus locations."""
        model, places = self.model, start.place
        if any(place.on and self._is_visible(place) for place in model.locations):
            return self, start
        fixed = {obj.name for obj in model.objects if obj.fixed and obj.name not in self._named}
        idle = {obj for obj in fixed.union(self.alike) if places.get(obj) in self.neutral}
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
        return Symmetry(smaller, self.visible, self._named), begin


def _loads_cost(costs: ActionCosts) -> bool:
    """Return whether costs do not depend on locations, and a transport costs at least as much as a transit."""
    if isinstance(costs, MeasuredCosts):
        return False
    return all(amount(costs["transit"], name) <= amount(costs["transport"], name) for name in cost_names(costs))
