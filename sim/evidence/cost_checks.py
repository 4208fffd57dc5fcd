"""The costs of a logged run's actions, checked against its scenario."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from prefplan.claims import Check
from prefplan.exact_costs import exact, to_number
from prefplan.logic.good_prefix import Label
from prefplan.models.manipulation.action import Action, at, holding
from prefplan.models.manipulation.action_costs import MeasuredCosts, Pair
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.manipulation.slots import free_slot, location_of, pose, slots_at_start
from sim.evidence.log import Log
from sim.evidence.replay import RecordedWorld

SURPRISES = ("retry", "replan")
"""Events after which a run goes on from observed positions."""


def check_action_costs(log: Log, world: RecordedWorld, trace: Sequence[Label]) -> Check:
    """Check that each action cost what the scenario says.

    Measured costs depend on the slots between which the hand moves. Until the first surprise these follow from the
    actions. After it, an action may cost what it does between any slots of its locations; from or to a place that the
    scenario does not have, such as where an object fell, what any action of its kind does.

    Args:
        log: the log.
        world: its world.
        trace: the propositions at the start and after every action.
    """
    name, hand, track = "action costs", world.model.start, _Track(world.model)
    table = {(kind, before, after): exact(cost) for kind, before, after, cost in log.about.measured}
    surprised = min((event.time for event in log.about.events if event.kind in SURPRISES), default=math.inf)
    for k, action in enumerate(log.about.actions, 1):
        symbolic = world.action(action.action)
        if symbolic is None:
            return Check(name, False, f"action {k} `{action.action}` is unknown")
        travels = world.model.operator(symbolic.kind).travels
        goal = symbolic.location if travels else hand
        pair = track.follow(symbolic)
        right = _costs(world, table, symbolic.kind, hand, goal)
        if pair in table and action.start < surprised:
            right = {table[pair]}
        if exact(action.cost) not in right:
            said = f"{to_number(right.pop())}" if len(right) == 1 else "another amount"
            return Check(name, False, f"action {k} `{action.action}` costs {said}, not {action.cost}")
        dropped = travels and symbolic.obj and holding(symbolic.obj) not in trace[k]
        hand = "" if dropped else goal
    return Check(name, True, "as in the scenario")


class _Track:
    """The slots of the hand and of the objects, as long as every action succeeds."""

    def __init__(self, model: ManipulationModel) -> None:
        places = [(obj.name, obj.start) for obj in model.objects]
        self._model = model
        self._capacity = {place.name: place.capacity for place in model.locations}
        slots = slots_at_start(places, {}, self._capacity)
        self._slots = {obj: (place, slots[obj]) for obj, place in places}
        self._hand = model.start

    def follow(self, action: Action) -> Pair:
        """Carry out an action; return its kind and the hand's poses before and after it."""
        before = self._hand
        if not action.location:
            place, slot = self._slots.pop(action.obj, (action.obj, 0))
        elif action.obj:
            place, slot = self._free(action.location)
        else:
            place, slot = action.location, 0
        if at(action.obj, action.location) in self._model.effect(action):
            self._slots[action.obj] = place, slot
        several = self._capacity.get(place, 1) > 1 and action.obj
        self._hand = pose(place, slot if several else None)
        return action.kind, before, self._hand

    def _free(self, place: str) -> tuple[str, int]:
        taken = [[(place, i) in self._slots.values()] for i in range(self._capacity.get(place, 1))]
        return place, int(free_slot(np.array(taken))[0])


def _costs(
    world: RecordedWorld, table: dict[tuple[str, str, str], Fraction], kind: str, hand: str, goal: str
) -> set[Fraction]:
    """Return what an action may cost."""
    costs = world.model.costs
    if not isinstance(costs, MeasuredCosts):
        return {exact(costs[kind])}
    between = {
        cost for (other, *ends), cost in table.items() if other == kind and [*map(location_of, ends)] == [hand, goal]
    }
    return between or {cost for (other, _, _), cost in table.items() if other == kind}
