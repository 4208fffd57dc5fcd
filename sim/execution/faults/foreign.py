"""Foreign: an unknown object appears at a location."""

from collections.abc import Sequence

import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from sim.execution.faults.fault import Fault, Injection, unknown
from sim.execution.faults.relocation import is_free, put_into
from sim.world.objects import why_no_spares


class Foreign(Fault):
    """A spare object is put into a free slot of a location."""

    kind = "foreign"
    noun = "LOCATION"
    spares = 1

    @classmethod
    def candidates(cls, model: ManipulationModel, rng: np.random.Generator) -> Sequence[str]:
        """See `Fault.candidates`."""
        return [place.name for place in model.locations]

    def objection(self, model: ManipulationModel) -> str | None:
        """See `Fault.objection`."""
        return unknown(self.argument, [place.name for place in model.locations], "location")

    def unavailable_because(self, model: ManipulationModel) -> str | None:
        """See `Fault.unavailable_because`."""
        if model.location(self.argument).on:
            return f"{self.argument} is on top of objects; unknown objects appear on the table"
        return why_no_spares(model)

    def inject(self, injection: Injection) -> dict[str, str] | None:
        """See `Fault.inject`."""
        cell = injection.cell
        slots = [slot for slot in cell.scene.slots[self.argument] if is_free(cell, slot)]
        if not slots:
            return None
        obj = next(injection.spares)
        put_into(cell, injection.rng, obj, slots[0])
        return {"object": obj}
