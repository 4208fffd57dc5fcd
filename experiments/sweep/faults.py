"""Random faults for the rollouts of a sweep."""

from __future__ import annotations

import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from sim.errors import SimulationError
from sim.execution.faults import SPELLINGS, Fault, targets_of, why_impossible

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


def possible_faults(model: ManipulationModel, kind: str) -> dict[str, tuple[str, ...]]:
    """Return the targets of the faults of `ANY` kind, or of a given kind, that can happen, by kind.

    Only movable objects are moved or knocked over.

    Raises:
        SimulationError: none can happen.
    """
    fixed = {obj.name for obj in model.objects if obj.fixed}
    found, reasons = dict[str, tuple[str, ...]](), set[str]()
    for each in SPELLINGS if kind == ANY else (kind,):
        why = {name: why_impossible(Fault(each, 1, name), model) for name in targets_of(each, model)}
        why |= {name: "every object is fixed" for name in fixed & why.keys()}
        if possible := tuple(name for name, reason in why.items() if reason is None):
            found[each] = possible
        reasons.update(filter(None, why.values()))
    if not found:
        raise SimulationError(f"{kind}: cannot happen: {'; '.join(sorted(reasons))}")
    return found


def random_faults(model: ManipulationModel, actions: int, *, seed: int, kind: str) -> tuple[Fault, ...]:
    """Return one to three `possible_faults` of `ANY` kind, or one of a given kind, each at a random action of a plan.

    A plan without actions has none.
    """
    if not actions:
        return ()
    rng = np.random.default_rng([seed, STREAM])
    possible = possible_faults(model, kind)
    faults = []
    most = MAX_FAULTS if kind == ANY else 1
    for _ in range(rng.integers(1, most, endpoint=True)):
        drawn, action = str(rng.choice(list(possible))), int(rng.integers(1, actions, endpoint=True))
        target, amount = str(rng.choice(possible[drawn])), 0.0
        if drawn == "miss":
            amount = float(rng.integers(1, MAX_MISSES, endpoint=True))
        elif drawn == "blind":
            amount = round(float(rng.uniform(*DROPOUT_S)), 1)
        faults.append(Fault(drawn, action, target, amount))
    return tuple(faults)
