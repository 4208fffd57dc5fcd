from __future__ import annotations

import pytest
from forged_logs import log_of_plan
from small_scenes import RELAXED_CUP

from experiments import scenarios
from prefplan.models.manipulation import Location, ManipulationModel, Object
from prefplan.scenario import loads
from sim.log import Log
from sim.scene import Scene, build_scene


@pytest.fixture(scope="session")
def arch_model() -> ManipulationModel:
    """Case Study 3: blue and green carry pink; a sanitizer, two bins and a spare spot."""
    return ManipulationModel(
        start="home",
        costs={"transit": 3, "grasp": 1, "transport": 5, "release": 1},
        locations=(
            Location("top", on=("left", "right")),
            Location("left", at=(0.50, 0.03)),
            Location("right", at=(0.50, -0.03)),
            Location("san", at=(0.45, 0.30), marks="sanitized"),
            Location("bin1", at=(0.38, -0.30), capacity=2, kind="bin"),
            Location("bin2", at=(0.56, -0.30), capacity=2, kind="bin"),
            Location("table", at=(0.62, 0.20)),
        ),
        objects=(
            Object("blue", "left", rgba=(0.10, 0.30, 0.90, 1)),
            Object("pink", "top", rgba=(0.95, 0.40, 0.65, 1)),
            Object("green", "right", rgba=(0.15, 0.65, 0.30, 1)),
        ),
    )


@pytest.fixture(scope="session")
def scene(arch_model: ManipulationModel) -> Scene:
    return build_scene(arch_model)


@pytest.fixture(scope="session")
def arch_log() -> Log:
    """The cheapest plan of Case Study 3: 14 actions, cost 34, mu 17."""
    return log_of_plan(scenarios.find("case_study_3"), seed=4)


@pytest.fixture(scope="session")
def relaxed_log() -> Log:
    """A cup put onto the tray as it is: washing is skipped, and the tray takes it for clean."""
    return log_of_plan(loads(RELAXED_CUP, name="relaxed"))
