"""`--perturb`: how much a rollout's world differs from the nominal one."""

from __future__ import annotations

from prefplan.errors import PrefplanError
from sim.errors import SimulationError
from sim.perturbation import Perturbation, read_perturbation


def perturbation_of(text: str | None, *, seed: int | None) -> Perturbation:
    """Return what `--perturb` says, the default where it says nothing.

    Raises:
        PrefplanError: it says nothing that can be read, or there is no seed to draw by.
    """
    if text is None:
        return Perturbation()
    if seed is None:
        raise PrefplanError("--perturb: needs --seed, the number that says what is drawn, e.g. --seed 1")
    try:
        return read_perturbation(text)
    except SimulationError as error:
        raise PrefplanError(f"--perturb: {error}") from None
