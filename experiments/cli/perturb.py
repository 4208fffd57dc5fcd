"""`--perturb`, `--fault` and `--noise`: how a rollout differs from the nominal one, and what goes wrong in it."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal

from prefplan.errors import PrefplanError
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.scenario.decode import Scenario
from sim.errors import SimulationError
from sim.execution.faults import Fault, read_fault
from sim.perception.sensors import NoisySensor, Sensor
from sim.world.randomization import Perturbation, read_perturbation


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


def faults_of(texts: Sequence[str], scenario: Scenario) -> tuple[Fault, ...]:
    """Return what `--fault` says each time; a scenario that cannot be carried out has no faults.

    Raises:
        PrefplanError: it says nothing that can be read.
    """
    if not isinstance(scenario.model, ManipulationModel):
        return ()
    try:
        return tuple(read_fault(text, scenario.model) for text in texts)
    except SimulationError as error:
        raise PrefplanError(f"--fault {error}") from None


def sensor_of(noise: Decimal | None, *, seed: int | None) -> Sensor | None:
    """Return the sensor that `--noise` says, in millimetres; None where it says nothing."""
    return NoisySensor(float(noise) / 1000, seed=seed or 0) if noise else None
