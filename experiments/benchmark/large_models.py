"""Manipulation models too large to enumerate, also with made-up measured costs."""

import math
import random
from dataclasses import replace
from decimal import Decimal
from itertools import product
from typing import NamedTuple

from prefplan import Location, ManipulationModel, Object, Order, Problem, Task
from prefplan.models.costs import Cost
from prefplan.models.manipulation.action_costs import QUANTITIES, ActionCosts, MeasuredCosts
from prefplan.models.manipulation.slots import hand_poses, location_of

COSTS = {"transit": 3, "grasp": 1, "transport": 5, "release": 1}
TWO_COSTS = {
    "transit": {"time": 3, "energy": 1},
    "grasp": {"time": 1, "energy": 2},
    "transport": {"time": 5, "energy": 9},
    "release": {"time": 1, "energy": 1},
}

BOXES = ("crate", "tray")


class Size(NamedTuple):
    """A model with two boxes, each for half of the objects.

    Attributes:
        objects: number of objects, and of locations for a single object.
        tasks: the objects that each task puts into a box; the tasks use the boxes in turn.
        costs: costs of the actions.
    """

    objects: int
    tasks: tuple[tuple[int, ...], ...]
    costs: ActionCosts = COSTS


ALL, FOUR = ((0, 2), (1, 3), (4, 6), (5, 7)), ((0,), (1,), (2,), (3,))

SIZES = {
    "6 objects, 8 locations, 3 tasks": Size(6, ((0, 2), (1, 3), (5,))),
    "8 objects, 10 locations, 3 tasks about 5 objects": Size(8, ((0, 2), (1, 3), (7,))),
    "8 objects, 10 locations, 4 tasks about all": Size(8, ALL),
    "20 objects, 22 locations, 4 tasks about 4 objects": Size(20, FOUR),
    "8 objects, 10 locations, 4 tasks about all, time and energy": Size(8, ALL, TWO_COSTS),
    "20 objects, 22 locations, 4 tasks about 4 objects, time and energy": Size(20, FOUR, TWO_COSTS),
}

TIME, TIME_AND_ENERGY = MeasuredCosts("time"), MeasuredCosts(("time", "energy"))

MEASURED = {
    **{
        f"{n} objects, {n + 2} locations, 2 tasks about 3 objects, time": Size(n, ((0, 2), (1,)), TIME)
        for n in (4, 5, 6, 8)
    },
    "8 objects, 10 locations, 2 tasks about 3 objects, time and energy": Size(8, ((0, 2), (1,)), TIME_AND_ENERGY),
    "8 objects, 10 locations, 4 tasks about all, time": Size(8, ALL, TIME),
}
"""Models with measured costs; all states of the first are enumerated."""


def large_model(size: Size) -> ManipulationModel:
    """Return a model of a size."""
    places = [Location(f"p{k}", at=(0.4, k / 10)) for k in range(size.objects)]
    boxes = [Location(box, at=(0.6, float(k)), capacity=(size.objects + 1) // 2) for k, box in enumerate(BOXES)]
    objects = tuple(Object(f"o{k}", start=f"p{k}") for k in range(size.objects))
    model = ManipulationModel("home", size.costs, (*places, *boxes), objects)
    return replace(model, costs=measured(model, size.costs)) if isinstance(size.costs, MeasuredCosts) else model


def measured(model: ManipulationModel, costs: MeasuredCosts) -> MeasuredCosts:
    """Return made-up measurements of a model's actions.

    An action takes 1 s plus 10 s per metre, and ten times as many joules; each value is varied by up to a fifth.
    """
    at = {place.name: place.at or (0.0, 0.0) for place in model.locations}
    hands = hand_poses({place.name: place.capacity for place in model.locations}, model.start)
    entries, rng = dict[tuple[str, str, str], Cost](), random.Random(0)
    for kind, before, after in product(model.kinds, hands, hands):
        places = location_of(before), location_of(after)
        if kind in ("transit", "transport") or places[0] == places[1]:
            metres = math.dist(*(at.get(place, (0.0, 0.0)) for place in places))
            usual = {"time": 1 + 10 * metres, "travel": 1 + 10 * metres, "energy": 10 + 100 * metres}
            drawn = {name: Decimal(str(round(usual[name] * rng.uniform(0.8, 1.2), 3))) for name in QUANTITIES}
            one = isinstance(costs.measured, str)
            entries[kind, before, after] = drawn[costs.quantity] if one else {q: drawn[q] for q in costs.quantities}
    return replace(costs, entries=entries)


def large_problem(size: Size) -> Problem:
    """Return a model with its tasks as a problem."""
    goals = (" & ".join(f"o{obj}_{BOXES[k % 2]}" for obj in objects) for k, objects in enumerate(size.tasks))
    tasks = [Task(f"task{k}", f"F ({goal})") for k, goal in enumerate(goals)]
    return Problem(large_model(size).transition_system(), tasks, Order())
