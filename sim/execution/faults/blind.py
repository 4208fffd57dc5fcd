"""Blind: the sensor observes nothing for a while."""

import math
from collections.abc import Sequence
from contextlib import suppress

import mujoco
import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from sim.execution.faults.fault import Fault, Injection
from sim.perception.sensors import ObjectPose, Sensor
from sim.world.scene import Scene

DROPOUT_S = (0.5, 3.0)
"""Shortest and longest random dropout, s: the robot waits longer than this."""


class Blind(Fault):
    """No object is observed for some seconds."""

    kind = "blind"
    noun = "SECONDS"

    @classmethod
    def candidates(cls, model: ManipulationModel, rng: np.random.Generator) -> Sequence[str]:
        """See `Fault.candidates`."""
        return [f"{rng.uniform(*DROPOUT_S):.1f}"]

    def objection(self, model: ManipulationModel) -> str | None:
        """See `Fault.objection`."""
        with suppress(ValueError):
            if math.isfinite(seconds := float(self.argument)) and seconds > 0:
                return None
        return f"{self.argument!r} does not say for how many seconds nothing is seen, as in {self.form()}"

    def inject(self, injection: Injection) -> dict[str, str]:
        """See `Fault.inject`."""
        cell = injection.cell
        cell.sensor = DropoutSensor(cell.sensor, until=float(cell.data.time) + float(self.argument))
        return {}


class DropoutSensor:
    """A sensor that observes nothing for a while."""

    def __init__(self, sensor: Sensor, *, until: float) -> None:
        """Wrap a sensor; it observes again from the simulated time `until` on, s."""
        self.samples, self.error = sensor.samples, sensor.error
        self._sensor, self._until = sensor, until

    def observe(self, scene: Scene, data: mujoco.MjData, obj: str) -> ObjectPose | None:
        """Return the observed pose of an object, or None if it is not observed."""
        return None if data.time < self._until else self._sensor.observe(scene, data, obj)
