"""Smaller models of a manipulation model that are equivalent for a given set of propositions, the *visible* ones.

Two reductions, both exact:

*Symmetry.* A location is *neutral* if its capacity is one, it is not closed, no visible proposition and no origin of an
exclusion names it, and it neither depends on other locations nor they on it. (With measured costs none is neutral: they
tell locations apart, but not objects.) Movable objects are *alike* if no visible proposition mentions them. Exchanging
neutral locations, or alike objects, maps the model onto itself and preserves costs and visible propositions. With
exclusions this holds within classes: two names are of one class if exchanging them leaves the set of exclusions as it
is. So one canonical state can stand for all states that result from such exchanges (its orbit). The canonical states
are a bisimulation quotient: every trajectory of one system has its counterpart in the other, action by action. (E. A.
Emerson and A. P. Sistla, "Symmetry and model checking", 1996.)

*Relevance.* An alike object at a neutral location need never be moved, if the other neutral locations can hold all
other movable objects at once, and no visible location rests on supports. Proof: in any plan, leave out the actions on
it, and let every other object that the plan puts at a neutral location be put at a free one. One is free, as the object
in the hand takes none. Costs do not depend on the location, so no action gets dearer. The actions left out change no
visible proposition, so this needs tasks that do not count actions, and preferences that do not gain from waiting. It
also holds with exclusions, if none names these other neutral locations or depends on an object that is not moved:
conditions require what holds, never what does not, so no action of the changed plan is excluded.

*Exclusions* are actions that do not exist in some states, such as those that no arm can do there. An action is excluded
where all conditions hold; each is that an object rests at a location, is in the hand, was grasped at a location, or has
a mark. Exclusions are texts in `prefplan.models.manipulation.symbolic.Barred`; here they are read for one model.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from math import perm
from typing import TYPE_CHECKING, NamedTuple

from prefplan.models.costs import by_name
from prefplan.models.manipulation.action_costs import ActionCosts, MeasuredCosts
from prefplan.models.manipulation.description import Location
from prefplan.models.manipulation.operators import read_action
from prefplan.models.manipulation.slots import hand_poses
from prefplan.models.manipulation.symbolic import Action, Barred, at, grasped_at, holding, marked

if TYPE_CHECKING:
    from prefplan.models.manipulation.model import ManipulationModel


IN_HAND = ""
"""Stands for the hand, where a condition names the location or the mark of an object."""


class Exclusion(NamedTuple):
    """An action that does not exist where all the conditions hold.

    Attributes:
        action: the action.
        conditions: (object, location) for an object that rests there, (object, mark), and (object, `IN_HAND`); no
            location has the name of a mark, as their propositions would be the same.
        origin: the location where the action's object was grasped; empty for any.
    """

    action: Action
    conditions: frozenset[tuple[str, str]]
    origin: str = ""


def most_states(model: ManipulationModel) -> int:
    """Return an upper bound of the number of states of a model, not counting marks: each object has its own slot."""
    slots, movable = sum(place.capacity for place in model.locations), sum(not obj.fixed for obj in model.objects)
    held = movable * perm(slots, movable - 1) if movable else 0
    return len(hand_poses(model.slot_counts, model.initial_state.hand)) * (perm(slots, movable) + held)


class Symmetry:
    """A model, and which of its parts are visible.

    Attributes:
        model: the model.
        barred: actions that do not exist where some propositions hold, as texts.
        exclusions: the same, read for the model.
        visible: the propositions that are visible.
        origins: (object, location): exclusions depend on whether the hand holds this object, grasped there.
        neutral: names of the neutral locations, in classes.
        alike: names of the movable objects of which nothing is visible, in classes.
    """

    def __init__(
        self, model: ManipulationModel, names: Collection[str], barred: Barred = (), *, places_alike: bool = True
    ) -> None:
        """Find the invisible objects and, if `places_alike`, the neutral locations.

        Visible are the propositions `names`, and the marks on which barred actions depend.
        """
        self.model, self.barred, self.exclusions = model, barred, read_exclusions(model, barred)
        conditions = {pair for one in self.exclusions for pair in one.conditions}
        self._excluded = {one.action.location for one in self.exclusions}.union(what for _, what in conditions)
        self.origins = {(one.action.obj, one.origin) for one in self.exclusions if one.origin}
        self.visible = frozenset(names) | {marked(obj, what) for obj, what in conditions if what in model.marks}
        self._objects = [obj.name for obj in model.objects]
        supports = {support for place in model.locations for support in (*place.on, *place.clear_of)}
        neutral = [
            place.name
            for place in (model.locations if places_alike else ())
            if place.capacity == 1 and not (place.on or place.clear_of or place.closed)
            if place.name not in supports.union(name for _, name in self.origins) and not self._is_visible(place)
        ]
        alike = [
            obj.name
            for obj in model.objects
            if not obj.fixed and not self.visible & {name for name, _ in model.propositions_of(obj.name)}
        ]
        self.neutral = classes(neutral, self.exclusions)
        self.alike = classes(alike, self.exclusions, objects=True)

    @property
    def neutral_locations(self) -> tuple[str, ...]:
        """The neutral locations of all classes."""
        return tuple(name for each in self.neutral for name in each)

    def _is_visible(self, place: Location) -> bool:
        names = {at(obj, place.name) for obj in self._objects}
        names |= {marked(obj, place.marks) for obj in self._objects if place.marks}
        return not self.visible.isdisjoint(names)

    def relevant(self) -> Symmetry:
        """Return the same without objects that need never be moved and their locations."""
        model, start, neutral = self.model, self.model.initial_state, self.neutral_locations
        places = start.place
        if not _loads_cost(model.costs) or any(place.on and self._is_visible(place) for place in model.locations):
            return self
        blockers = {obj for one in self.exclusions for obj, _ in one.conditions if obj != one.action.obj}
        fixed = {obj.name for obj in model.objects if obj.fixed}
        idle = {obj for obj in fixed.union(*self.alike) - blockers if places.get(obj) in neutral}
        movable = [obj for obj in model.objects if not obj.fixed and obj.name not in idle]
        closed = self._excluded | {place for obj, place in places.items() if obj in idle | fixed}
        taken = {places[obj] for obj in idle}
        kept = tuple(place for place in model.locations if place.name not in taken)
        if not kept or sum(place not in closed for place in neutral) < len(movable):
            return self
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
        return Symmetry(smaller, self.visible, self.barred)


def _loads_cost(costs: ActionCosts) -> bool:
    """Return whether costs do not depend on locations, and a transport costs at least as much as a transit."""
    if isinstance(costs, MeasuredCosts):
        return False
    loaded = by_name(costs["transport"])
    return all(cost <= loaded[name] for name, cost in by_name(costs["transit"]).items())


def read_exclusions(model: ManipulationModel, barred: Barred) -> frozenset[Exclusion]:
    """Return exclusions given as texts, without those that concern no state of a model.

    Raises:
        ModelError: an action is of an unknown kind, or has not the names that its kind has.
    """
    places, read = [place.name for place in model.locations], dict[str, tuple[str, str]]()
    for obj in (obj.name for obj in model.objects):
        read |= {holding(obj): (obj, IN_HAND)} | {at(obj, place): (obj, place) for place in places}
        read |= {marked(obj, mark): (obj, mark) for mark in model.marks}
    objects, locations = {"", *(obj.name for obj in model.objects)}, {"", *places}
    exclusions = set[Exclusion]()
    for names, text in barred:
        action = read_action(text, model.operators)
        grasped = grasped_at(action.obj, "")
        # An origin may be a location that the model lacks.
        origins = {name.removeprefix(grasped) for name in names if name.startswith(grasped)}
        others = {name for name in names if not name.startswith(grasped)}
        if action.obj in objects and action.location in locations and others <= read.keys() and len(origins) <= 1:
            exclusions.add(Exclusion(action, frozenset(map(read.__getitem__, others)), *origins))
    return frozenset(exclusions)


def classes(
    names: Sequence[str], exclusions: Collection[Exclusion], *, objects: bool = False
) -> tuple[tuple[str, ...], ...]:
    """Return classes of locations or objects: exchanging two of one class leaves the set of exclusions as it is."""
    found: list[list[str]] = []
    for name in names:
        for each in found:
            swap = {name: each[0], each[0]: name}
            swaps = (swap, {}) if objects else ({}, swap)
            if all(_renamed(one, *swaps) in exclusions for one in exclusions):
                each.append(name)
                break
        else:
            found.append([name])
    return tuple(map(tuple, found))


def _renamed(exclusion: Exclusion, objects: Mapping[str, str], locations: Mapping[str, str]) -> Exclusion:
    """Return an exclusion with other names for some objects and locations."""
    action, conditions, origin = exclusion
    obj, location = objects.get(action.obj, action.obj), locations.get(action.location, action.location)
    pairs = frozenset((objects.get(one, one), locations.get(what, what)) for one, what in conditions)
    return Exclusion(replace(action, obj=obj, location=location), pairs, origin)
