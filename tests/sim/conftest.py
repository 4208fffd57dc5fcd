from __future__ import annotations

import numpy as np
import pytest
from forged_logs import log_of_run
from scenario_texts import RELAXED_CUP, shipped

from prefplan.claims import Check
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.scenario.decode import loads
from sim.evidence import certificate
from sim.evidence.log import Log
from sim.evidence.replay import RecordedWorld
from sim.evidence.resimulation import resimulate
from sim.evidence.touch_checks import Touches
from sim.world.scene import Scene, build_scene


@pytest.fixture(scope="session")
def scene(arch_model: ManipulationModel) -> Scene:
    return build_scene(arch_model)


@pytest.fixture(scope="session")
def arch_log() -> Log:
    """The cheapest plan of Case Study 3: 14 actions, cost 34, mu 17."""
    return log_of_run(shipped("case_study_3"), seed=4)


@pytest.fixture(scope="session")
def relaxed_log() -> Log:
    """A cup put onto the tray unwashed: washing is skipped, and the other task assumes that the cup is clean."""
    return log_of_run(loads(RELAXED_CUP, name="relaxed"))


@pytest.fixture(scope="session")
def pressed(arch_log: Log, relaxed_log: Log) -> dict[int, np.ndarray]:
    """The forces on the pads in these logs, by their number of frames."""
    forces = {}
    for log in (arch_log, relaxed_log):
        world = RecordedWorld(log)
        forces[len(log.times)] = resimulate(log, world, Touches(log, world)).arrays["pad_forces"]
    return forces


@pytest.fixture
def claims_alone(monkeypatch: pytest.MonkeyPatch, pressed: dict[int, np.ndarray]) -> None:
    """Leave out the simulation and the checks of contacts, most of the work, where only claims are tested."""

    def physics(log: Log, world: RecordedWorld) -> tuple[tuple[Check, ...], bool]:
        world.pad_forces[:] = pressed[len(log.times)]
        return (), False

    monkeypatch.setattr(certificate, "_physics", physics)
