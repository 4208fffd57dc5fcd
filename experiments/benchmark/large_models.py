"""Manipulation models too large to enumerate, also with made-up measured costs."""

import json
import math
import random
from decimal import Decimal
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from prefplan.models.manipulation.action_costs import QUANTITIES
from prefplan.models.manipulation.measured_costs import Measurement, Measurements, measurements_file, to_json
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.manipulation.slots import hand_poses, location_of
from prefplan.problem import Problem
from prefplan.scenario.decode import load

COSTS = "{ transit = 3, grasp = 1, transport = 5, release = 1 }"
TWO_COSTS = (
    "{ transit = { time = 3, energy = 1 }, grasp = { time = 1, energy = 2 }, "
    "transport = { time = 5, energy = 9 }, release = { time = 1, energy = 1 } }"
)


class Size(NamedTuple):
    """A model: the number of objects and of single places, the objects that each task puts into a box, and the costs.

    Two boxes have room for half of the objects each; the tasks use them in turn.
    """

    objects: int
    tasks: tuple[tuple[int, ...], ...]
    costs: str = COSTS


ALL, FOUR = ((0, 2), (1, 3), (4, 6), (5, 7)), ((0,), (1,), (2,), (3,))

SIZES = {
    "6 objects, 8 locations, 3 tasks": Size(6, ((0, 2), (1, 3), (5,))),
    "8 objects, 10 locations, 3 tasks about 5 objects": Size(8, ((0, 2), (1, 3), (7,))),
    "8 objects, 10 locations, 4 tasks about all": Size(8, ALL),
    "20 objects, 22 locations, 4 tasks about 4 objects": Size(20, FOUR),
    "8 objects, 10 locations, 4 tasks about all, time and energy": Size(8, ALL, TWO_COSTS),
    "20 objects, 22 locations, 4 tasks about 4 objects, time and energy": Size(20, FOUR, TWO_COSTS),
}

TIME, TIME_AND_ENERGY = '{ measured = "time" }', '{ measured = ["time", "energy"] }'

MEASURED = {
    **{
        f"{n} objects, {n + 2} locations, 2 tasks about 3 objects, time": Size(n, ((0, 2), (1,)), TIME)
        for n in (4, 5, 6, 8)
    },
    "8 objects, 10 locations, 2 tasks about 3 objects, time and energy": Size(8, ((0, 2), (1,)), TIME_AND_ENERGY),
    "8 objects, 10 locations, 4 tasks about all, time": Size(8, ALL, TIME),
}
"""Models with measured costs; all states of the first are enumerated."""


def scenario(size: Size) -> str:
    """Return a scenario file."""
    names = [f"p{k} = {{ at = [0.4, {0.1 * k:.1f}] }}" for k in range(size.objects)]
    capacity = (size.objects + 1) // 2
    names += [f"{box} = {{ at = [0.6, {k}.0], capacity = {capacity} }}" for k, box in enumerate(("crate", "tray"))]
    lines = ["[model]", 'kind = "manipulation"', 'start = "home"', f"costs = {size.costs}", "[model.locations]", *names]
    lines += ["[model.objects]", *(f'o{k} = {{ start = "p{k}" }}' for k in range(size.objects))]
    for k, objects in enumerate(size.tasks):
        goal = " & ".join(f"o{obj}_{('crate', 'tray')[k % 2]}" for obj in objects)
        lines += ["[[tasks]]", f'name = "task{k}"', f'formula = "F ({goal})"']
    return "\n".join([*lines, "[preference]", 'kind = "order"', ""])


def write_measurements(path: Path) -> None:
    """Write made-up measurements beside a scenario with measured costs.

    An action takes 1 s plus 10 s per metre, and ten times as many joules; each value is varied by up to a fifth.
    """
    model = load(path, measured=False).model
    assert isinstance(model, ManipulationModel)
    at = {place.name: place.at or (0.0, 0.0) for place in model.locations}
    hands = hand_poses({place.name: place.capacity for place in model.locations}, model.start)
    done, rng = [], random.Random(0)
    for kind, before, after in product(model.kinds, hands, hands):
        places = location_of(before), location_of(after)
        if kind in ("transit", "transport") or places[0] == places[1]:
            metres = math.dist(*(at.get(place, (0.0, 0.0)) for place in places))
            usual = {"time": 1 + 10 * metres, "travel": 1 + 10 * metres, "energy": 10 + 100 * metres}
            effort = {name: Decimal(str(round(usual[name] * rng.uniform(0.8, 1.2), 3))) for name in QUANTITIES}
            done.append(Measurement((kind, before, after), effort, samples=1))
    contents = to_json(model, Measurements(tuple(done), robot="made-up", sources=""))
    measurements_file(path).write_text(json.dumps(contents), encoding="utf-8")


def large_problem(size: Size) -> Problem:
    """Return a model with its tasks as a problem."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "large.toml")
        path.write_text(scenario(size), encoding="utf-8")
        if "measured" in size.costs:
            write_measurements(path)
        return load(path).problem()
