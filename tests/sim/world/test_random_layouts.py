"""Random walks through the models of random tables: towers, bins and lamps anywhere in reach."""

from __future__ import annotations

import numpy as np
import pytest
from skill_runs import assert_good

from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from sim.errors import SimulationError
from sim.execution.executor import execute
from sim.robots.panda import PANDA
from sim.world.layout import arrange
from sim.world.scene import build_scene

COSTS = {"transit": 1, "grasp": 1, "transport": 1, "release": 1}


def random_model(rng: np.random.Generator) -> ManipulationModel:
    """Return a model that the arm can work in, drawn again until there is one."""
    while True:
        places: list[Location] = []
        for i in range(int(rng.integers(3, 6))):
            place = _random_place(f"place{i}", rng)
            if _fits(ManipulationModel("home", COSTS, (*places, place), ())):
                places.append(place)
        towers = []
        for place in [place for place in places if place.capacity == 1][:2]:
            below = place.name
            for storey in range(int(rng.integers(0, 4))):
                towers.append(Location(f"{place.name}_{storey}", on=(below,)))
                below = towers[-1].name
        locations = (*places, *towers)
        if len(places) < 2:
            continue
        model = ManipulationModel("home", COSTS, locations, _random_objects(locations, rng))
        if _fits(model):
            return model


def random_walk(model: ManipulationModel, steps: int, rng: np.random.Generator) -> list[str]:
    """Return that many actions in a row, from the model's start; transits less often than what moves objects."""
    system = model.transition_system()
    state, actions = system.start, []
    for _ in range(steps):
        names = [system.action_names[system.actions[edge]] for edge in system.edges(state)]
        weights = np.array(
            [{"transit": 1, "grasp": 6, "transport": 2, "release": 4}[name.split()[0]] for name in names]
        )
        actions.append(names[rng.choice(len(names), p=weights / weights.sum())])
        state, _ = system.step(state, actions[-1])
    return actions


def _random_place(name: str, rng: np.random.Generator) -> Location:
    radius, bearing = rng.uniform(0.34, 0.76), rng.uniform(-1.3, 1.3) * (1 if rng.random() < 0.7 else 1.9)
    at = (round(float(radius * np.cos(bearing)), 3), round(float(radius * np.sin(bearing)), 3))
    kind = str(rng.choice(["spot", "bin", "pad"], p=[0.55, 0.25, 0.2]))
    capacity = 2 if kind == "bin" and rng.random() < 0.5 else 1
    return Location(name, at=at, kind=kind, capacity=capacity, marks="clean" if rng.random() < 0.25 else None)


def _random_objects(locations: tuple[Location, ...], rng: np.random.Generator) -> tuple[Object, ...]:
    """Return two to four objects, towers filled from below and rather than other places."""
    spaces = {place.name: place.capacity for place in locations}
    objects = []
    for i in range(int(rng.integers(2, 5))):
        free = [place for place in locations if spaces[place.name] and all(spaces[name] == 0 for name in place.on)]
        if not free:
            break
        weights = np.array([3.0 if place.on else 1.0 for place in free])
        place = free[rng.choice(len(free), p=weights / weights.sum())]
        spaces[place.name] -= 1
        objects.append(Object(f"obj{i}", place.name))
    return tuple(objects)


def _fits(model: ManipulationModel) -> bool:
    try:
        arrange(model, PANDA)
    except SimulationError:
        return False
    return True


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_random_walks_come_out_as_predicted_without_a_touch_or_a_limit_passed(seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = random_model(rng)
    assert_good(execute(build_scene(model, meshes=False), random_walk(model, 12, rng), seed=seed))
