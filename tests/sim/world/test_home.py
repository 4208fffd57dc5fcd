"""The start: nothing stands in the robot's way at home, and nothing there is forgotten once the arm moves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenario_texts import cup_scenario
from skill_runs import contacts

from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.manipulation.surroundings import Fixture
from prefplan.scenario.decode import loads
from sim.errors import SimulationError
from sim.execution.executor import execute
from sim.world.robot_clearance import HOME_CLEARANCE_M
from sim.world.scene import build_scene, initial_state

TOP_M = 0.465
"""Height of a pillar on which an object is beside a finger of the Panda's open hand at home."""

FINGER_Y_M = 0.065
"""Outer side of that finger."""


def model_with(*fixtures: Fixture, cup: tuple[float, ...] = (0.5, 0.2)) -> ManipulationModel:
    model = loads(cup_scenario(places={"desk": f"{{ at = {list(cup)} }}", "tray": "{ at = [0.45, -0.2] }"})).model
    assert isinstance(model, ManipulationModel)
    return replace(model, fixtures=fixtures)


def pillar_beside(distance: float) -> ManipulationModel:
    """Return a model in which the cup on a pillar is at a distance from the outer side of the open finger, m."""
    y = FINGER_Y_M + distance + 0.0225
    pillar = Fixture("pillar", "box", (0.325, y, TOP_M / 2), (0.1, 0.1, TOP_M))
    return model_with(pillar, cup=(0.325, y, TOP_M))


def test_the_hand_leaves_a_wall_between_its_open_fingers_without_touching_it() -> None:
    wall = Fixture("wall", "box", (0.5, 0.0, 0.25), (0.5, 0.02, 0.5))
    rollout = execute(build_scene(model_with(wall)), ["transit desk"], seed=1)
    assert rollout.completed, rollout.reason
    assert contacts(rollout.events) == []


@pytest.mark.parametrize(
    ("y", "words"),
    [
        (0.045, r"the robot's right_finger at home would be \d+\.\d mm inside it; move it away"),
        (
            FINGER_Y_M + 0.002,
            r"the robot's right_finger at home would be only 2\.0 mm from it; at least 4 mm; move it away",
        ),
    ],
)
def test_a_fixture_in_the_way_at_home_is_refused_with_its_distance(y: float, words: str) -> None:
    post = Fixture("post", "box", (0.307, y + 0.005, 0.26), (0.02, 0.01, 0.52))
    with pytest.raises(SimulationError, match=f"^fixtures.post: {words}$"):
        build_scene(model_with(post))


def test_an_object_in_the_way_at_home_is_refused() -> None:
    with pytest.raises(
        SimulationError, match=r"objects.cup: the robot's right_finger at home would be 10.0 mm inside it"
    ):
        build_scene(pillar_beside(-0.01))


def test_no_random_start_puts_an_object_into_the_hand() -> None:
    scene = build_scene(pillar_beside(HOME_CLEARANCE_M + 0.0005))
    robot = scene.robot.bodies(scene.mujoco)
    for seed in range(20):
        data = initial_state(scene, seed=seed, position=0.01)
        assert not robot[scene.mujoco.geom_bodyid[data.contact.geom]].any(), seed
        assert np.abs(data.joint("cup").qpos[:2] - scene.slots["desk"][0].position[:2]).max() <= 0.01
