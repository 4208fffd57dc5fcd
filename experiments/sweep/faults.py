"""Faults drawn at random for the rollouts of a sweep."""

from __future__ import annotations

import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from sim.execution.faults import SPELLINGS, Fault

MOST_FAULTS = 3
"""Faults in one rollout."""

MISSES = 2
"""Grasps in a row that one fault spoils at most: fewer than are tried."""

BLIND = (0.5, 3.0)
"""For how long nothing is seen, s: shorter than the robot's patience."""

STREAM = 3
"""Number of the random stream that faults are drawn from: none of the simulation's, which play them out."""


def random_faults(model: ManipulationModel, actions: int, *, seed: int) -> tuple[Fault, ...]:
    """Return one to three faults of any kind, each at any action of a plan.

    Args:
        model: what can be moved, and where to.
        actions: length of the plan, at least 1.
        seed: of the rollout.
    """
    rng = np.random.default_rng([seed, STREAM])
    things = [thing.name for thing in model.objects if not thing.fixed]
    places = [place.name for place in model.locations]
    faults = []
    for _ in range(rng.integers(1, MOST_FAULTS, endpoint=True)):
        kind, action = str(rng.choice(list(SPELLINGS))), int(rng.integers(1, actions, endpoint=True))
        target, amount = "", 0.0
        if kind in ("move", "knock"):
            target = str(rng.choice(things))
        elif kind == "foreign":
            target = str(rng.choice(places))
        elif kind == "miss":
            amount = float(rng.integers(1, MISSES, endpoint=True))
        elif kind == "blind":
            amount = round(float(rng.uniform(*BLIND)), 1)
        faults.append(Fault(kind, action, target, amount))
    return tuple(faults)
