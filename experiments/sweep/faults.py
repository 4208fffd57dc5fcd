"""Random faults for the rollouts of a sweep."""

import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from sim.errors import SimulationError
from sim.execution.faults.fault import Fault, draw_fault, kinds

MAX_FAULTS = 3
"""Greatest number of faults in one rollout."""

STREAM = 3
"""Number of the random stream for faults; the simulation has its own."""

ANY = "random"
"""Faults of any kind, as `--faults` names them."""


def possible_kinds(model: ManipulationModel, kind: str) -> list[str]:
    """Return the kinds of faults that can happen, among all (`ANY`) or one; raise SimulationError if none can."""
    possible, reasons = list[str](), set[str]()
    for each in kinds() if kind == ANY else (kind,):
        try:
            draw_fault(each, 1, model, np.random.default_rng(0))
            possible.append(each)
        except SimulationError as error:
            reasons.add(str(error))
    if not possible:
        raise SimulationError(f"{kind}: cannot happen: {'; '.join(sorted(reasons))}")
    return possible


def random_faults(model: ManipulationModel, actions: int, *, seed: int, kind: str) -> tuple[Fault, ...]:
    """Return one to three faults of the `possible_kinds`, or one of a given kind, each at a random action of a plan.

    A plan without actions has none.
    """
    if not actions:
        return ()
    rng, possible = np.random.default_rng([seed, STREAM]), possible_kinds(model, kind)
    most = MAX_FAULTS if kind == ANY else 1
    return tuple(
        draw_fault(str(rng.choice(possible)), int(rng.integers(1, actions, endpoint=True)), model, rng)
        for _ in range(rng.integers(1, most, endpoint=True))
    )
