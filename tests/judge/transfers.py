"""Fronts of what the arm can do, by all transfers that it can carry out: `PYTHONPATH=tests python -m judge.transfers`.

In small cramped scenes, every transfer in every arrangement that can be reached is rehearsed, whether or not a plan
needs it, and the front over those that succeed is compared with that of the planner, which asks only for what its plans
need and concludes from few failures that many transfers are impossible.
"""

from __future__ import annotations

import argparse
import os
import random
import sys
from collections.abc import Sequence
from functools import cache
from unittest.mock import patch

from random_manipulation import enumerated
from small_models import COSTS

from judge.physics import rehearsal_of
from prefplan import Location, ManipulationModel, Object, Order, Planner, Problem, Task
from prefplan.errors import PrefplanError
from prefplan.models.feasibility import Transfer
from prefplan.models.manipulation.surroundings import Fixture
from prefplan.models.manipulation.symbolic import at
from sim.capability.answers import Capability
from sim.capability.attempts import Attempts
from sim.skills.catalogue import SKILLS
from sim.world.scene import Scene, build_scene

GRID_M = (0.40, 0.47, 0.54, 0.61), (-0.14, -0.07, 0.0, 0.07)
"""Locations are drawn from this grid, (x, y); walls stand half-way between its lines."""

SIZES = (0.04, 0.04, 0.05), (0.045, 0.045, 0.1), (0.03, 0.055, 0.08), (0.06, 0.03, 0.06), (0.04, 0.04, 0.16)
"""Sizes of the boxes, m."""


def random_model(seed: int) -> ManipulationModel:
    """Draw four or five locations, two or three boxes, and one to four walls between them."""
    rng, (xs, ys) = random.Random(seed), GRID_M
    points = rng.sample([(x, y) for x in xs for y in ys], rng.choice((4, 4, 5)))
    places = tuple(Location(f"p{k}", at=point) for k, point in enumerate(points))
    boxes = tuple(Object(f"o{k}", f"p{k}", kind="box", size=rng.choice(SIZES)) for k in range(rng.choice((2, 2, 2, 3))))
    walls = []
    for k in range(rng.randint(1, 4)):
        length, height = rng.choice((0.1, 0.2, 0.3)), rng.choice((0.1, 0.2, 0.3))
        if rng.random() < 0.5:
            middle, size = (rng.choice(xs) + 0.035, rng.choice(ys), height / 2), (0.01, length, height)
        else:
            middle, size = (rng.choice(xs), rng.choice(ys) + 0.035, height / 2), (length, 0.01, height)
        walls.append(Fixture(f"w{k}", "box", at=middle, size=size))
    return ManipulationModel("home", COSTS, places, boxes, fixtures=tuple(walls))


def random_tasks(seed: int, model: ManipulationModel) -> list[Task]:
    """Draw one or two tasks: objects at places, one after the other."""
    rng = random.Random(seed)
    pairs = [at(obj.name, place.name) for obj in model.objects for place in model.locations if place.name != obj.start]
    forms = "F ({0} & F {1})", "F {0}"
    return [Task(f"t{k}", rng.choice(forms).format(*rng.sample(pairs, 2))) for k in range(rng.choice((1, 2)))]


def fronts(scene: Scene, tasks: Sequence[Task]) -> tuple[list[tuple[float, ...]], list[tuple[float, ...]], int]:
    """Return the planner's front, that over all transfers which succeed in a rehearsal, and how many were rehearsed."""
    model, attempts = scene.model, Attempts(scene, SKILLS)

    @cache
    def succeeds(transfer: Transfer) -> bool:
        return attempts.run(rehearsal_of(transfer))[1] is None

    def exists(action: str, origin: str, label: frozenset[str]) -> bool:
        kind, obj, *location = action.split()
        pairs = [(obj.name, place.name) for obj in model.objects for place in model.locations]
        others = tuple(pair for pair in pairs if at(*pair) in label)
        return kind != "release" or succeeds(Transfer(obj, origin, *location, others))

    with patch.dict(os.environ, XDG_CACHE_HOME=os.devnull):  # no answer is kept
        able = Problem(model, tasks, Order(), feasible=Capability(model, scene=scene))
        found = Planner(able).front()
    expected = Planner(Problem(enumerated(model, exists), tasks, Order())).front()
    values = [[tuple(plan.objectives.values()) for plan in front] for front in (found, expected)]
    return values[0], values[1], succeeds.cache_info().currsize


def main() -> int:
    """Compare the fronts of some scenes; the exit status is 1 if one differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    options, compared, changed, different = parser.parse_args(), 0, 0, 0
    for seed in range(options.seed, options.seed + options.scenes):
        model = random_model(seed)
        tasks = random_tasks(seed, model)
        try:
            scene = build_scene(model)
            abstract = [tuple(plan.objectives.values()) for plan in Planner(Problem(model, tasks, Order())).front()]
        except PrefplanError:
            continue
        found, expected, rehearsed = fronts(scene, tasks)
        compared, changed, different = compared + 1, changed + (found != abstract), different + (found != expected)
        print(f"{seed}: {found}, of {rehearsed} transfers {expected}, abstract {abstract}", flush=True)
    print(f"{compared} fronts, {changed} not the abstract ones: {different} differ from those of all transfers")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
