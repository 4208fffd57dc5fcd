from __future__ import annotations

import pytest
from forged_logs import log_of_run
from scenario_texts import RELAXED_CUP, shipped

from prefplan.models.manipulation.model import ManipulationModel
from prefplan.scenario.decode import loads
from sim.evidence import certificate
from sim.evidence.log import Log
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


@pytest.fixture
def claims_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the simulation and the checks of contacts, most of the work, where only claims are tested."""
    monkeypatch.setattr(certificate, "_physics", lambda log, world: ((), False))
