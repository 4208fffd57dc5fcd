"""Random faults for the rollouts of a sweep."""

from __future__ import annotations

import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from sim.execution.faults import SPELLINGS, Fault

MAX_FAULTS = 3
"""Greatest number of faults in one rollout."""

MAX_MISSES = 2
"""Greatest number of grasps in a row that one fault makes fail: fewer than the robot tries."""

DROPOUT_S = (0.5, 3.0)
"""Shortest and longest sensor dropout: shorter than the robot waits."""

STREAM = 3
"""Number of the random stream for faults; the simulation has its own."""


ANY = "random"
"""Faults of any kind, as `--faults` names them."""


def random_faults(model: ManipulationModel, actions: int, *, seed: int, kind: str) -> tuple[Fault, ...]:
    """Return one to three faults of `ANY` kind, or one of a given kind, each at a random action of a plan.

    Only movable objects are moved or knocked over. The plan must have at least one action.
    """
    rng = np.random.default_rng([seed, STREAM])
    objects = [obj.name for obj in model.objects if not obj.fixed]
    locations = [location.name for location in model.locations]
    faults = []
    kinds, most = (list(SPELLINGS), MAX_FAULTS) if kind == ANY else ([kind], 1)
    for _ in range(rng.integers(1, most, endpoint=True)):
        kind, action = str(rng.choice(kinds)), int(rng.integers(1, actions, endpoint=True))
        target, amount = "", 0.0
        if kind in ("move", "knock"):
            target = str(rng.choice(objects))
        elif kind == "foreign":
            target = str(rng.choice(locations))
        elif kind == "miss":
            amount = float(rng.integers(1, MAX_MISSES, endpoint=True))
        elif kind == "blind":
            amount = round(float(rng.uniform(*DROPOUT_S)), 1)
        faults.append(Fault(kind, action, target, amount))
    return tuple(faults)
