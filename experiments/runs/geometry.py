"""Plans that the arm can carry out: a scenario whose planner asks the simulated arm what it can do."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import prefplan as pp
from experiments.cli.start import has_simulation
from experiments.cli.status import is_quiet, tell

if TYPE_CHECKING:
    from prefplan.models.feasibility import Transfer
    from sim.capability.answers import Capability
    from sim.capability.place_check import PlaceCheck
    from sim.world.scene import Scene

NOT_CHECKED = "geometry not checked:"
"""Beginning of the line on stderr which warns that plans may need what the arm cannot do."""


class AskedArm:
    """The arm of a scene; if it cannot work there, stderr says so once, and everything counts as possible.

    Attributes:
        failed: whether the scene cannot be built, or the hand cannot begin in it.
    """

    def __init__(self, capability: Capability, path: object) -> None:
        """Take what the arm can do in the scenario of a file."""
        self._capability, self._path, self.failed = capability, path, False

    def rehearse(self, transfer: Transfer) -> PlaceCheck | None:
        """See `prefplan.models.feasibility.Feasible`."""
        from sim.errors import RobotError, SimulationError

        if not self.failed:
            try:
                if (fault := self._capability.check_start()) is None:
                    return self._capability.rehearse(transfer)
                why = fault
            except (SimulationError, RobotError) as error:
                faults = error.faults if isinstance(error, SimulationError) else (f"robot: {error}",)
                why = "; ".join(f"model.{fault}" for fault in faults)
            self.failed = True
            tell(f"{NOT_CHECKED} {self._path}: {why}")
        return None


def asking(scenario: pp.Scenario, *, abstract: bool = False) -> pp.Scenario:
    """Return a scenario whose plans need only what the arm can do, where that can be known.

    A scenario without an arm, or one that is abstract already, is returned as it is; the argument makes one abstract.
    If the simulation is not installed, stderr says so, unless `-q` is given.
    """
    if not isinstance(scenario.model, pp.ManipulationModel) or scenario.model.abstract:
        return scenario
    if abstract:
        return replace(scenario, model=replace(scenario.model, abstract=True))
    if not has_simulation():
        if not is_quiet():
            tell(f"{NOT_CHECKED} the simulation is not installed; see `prefplan doctor`")
        return scenario
    from sim.capability.answers import Capability

    return replace(scenario, feasible=AskedArm(Capability(scenario.model), scenario.path))


def asking_in(scenario: pp.Scenario, scene: Scene, *, robot: str | None = None) -> pp.Scenario:
    """Return a scenario whose plans need only what the arm can do in its scene, also if it says that it is abstract.

    The scene has the robot of this name or, if it is None, the scenario's robot.
    """
    from sim.capability.answers import Capability

    assert isinstance(scenario.model, pp.ManipulationModel)
    return replace(scenario, feasible=Capability(scenario.model, robot=robot, scene=scene))
