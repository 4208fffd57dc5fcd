"""Exclusions are confirmed, and false ones refuted, by the judge that tries them in physics."""

from __future__ import annotations

from judge.physics import is_possible, trials

from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from prefplan.models.manipulation.surroundings import Fixture
from sim.capability.feasibility import Feasibility
from sim.capability.place_check import PlaceCheck
from sim.world.scene import Scene, build_scene

COSTS = {"transit": 1, "grasp": 1, "transport": 1, "release": 1}


def scene_of(height: float, *, board: float = 0.159) -> Scene:
    """Return a box of a height, m, under a board at another height, m."""
    shelf = Fixture("shelf", "shelf", at=(0.62, 0.3, 0.0), size=(0.24, 0.5, board + 0.2), yaw=180, boards=(0.0, board))
    places = Location("low", at=(0.55, 0.39)), Location("free", at=(0.45, -0.2))
    box = Object("box", "low", kind="box", size=(0.043, 0.068, height))
    return build_scene(ManipulationModel("home", COSTS, places, (box,), fixtures=(shelf,)))


def refuted(scene: Scene, found: PlaceCheck) -> bool:
    return any(is_possible(scene, trial) for trial in trials(scene.model, found))


def test_what_a_run_can_do_refutes_an_exclusion() -> None:
    assert refuted(scene_of(0.071), PlaceCheck("box", "low", "forged", take=False))
    assert refuted(scene_of(0.071), PlaceCheck("box", "free", "forged", put=False))
    assert not refuted(scene_of(0.071), PlaceCheck("box", "low", "only while something stands there"))


def test_what_is_impossible_is_confirmed() -> None:
    scene = scene_of(0.1, board=0.12)
    found = Feasibility(scene).check("box", "low")
    assert not found.take and not refuted(scene, found)
