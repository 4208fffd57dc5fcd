from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest
from small_models import TOWER

from prefplan.models.manipulation.model import ManipulationState
from sim.motion.kinematics import Arm
from sim.motion.trajectory import ToolPose
from sim.perception.grounding import NOWHERE, mismatch, slot_of
from sim.perception.grounding import observe as observe_poses
from sim.perception.sensors import object_pose, true_poses
from sim.robots.arms.panda import PANDA
from sim.world.scene import Scene, build_scene, initial_state
from sim.world.shapes import CUBE_EDGE_M

Arrange = Callable[..., mujoco.MjData]

MARKS = frozenset({("blue", "sanitized")})


@pytest.fixture
def arrange(scene: Scene) -> Arrange:
    """Return the start state with some objects put elsewhere: name = (x, y, z) or (x, y, z, roll in degrees)."""

    def put(**poses: tuple[float, ...]) -> mujoco.MjData:
        data = initial_state(scene)
        for name, pose in poses.items():
            half = np.radians(pose[3]) / 2 if len(pose) > 3 else 0.0
            data.joint(name).qpos[:] = [*pose[:3], np.cos(half), np.sin(half), 0.0, 0.0]
        mujoco.mj_forward(scene.mujoco, data)
        return data

    return put


def observe(scene: Scene, data: mujoco.MjData, **options: Any) -> ManipulationState:
    """Return the state grounded in exact poses."""
    return observe_poses(scene, data, true_poses(scene, data), **options)


def places(scene: Scene, data: mujoco.MjData) -> dict[str, str]:
    return observe(scene, data, hand="home", held=None).place


def test_the_start_is_observed_as_the_model_says(scene: Scene, arrange: Arrange) -> None:
    system = scene.model.transition_system().listed
    assert observe(scene, arrange(), hand="home", held=None) == system.states[system.start]


def test_objects_off_by_some_millimetres_are_still_in_place(scene: Scene) -> None:
    for seed in range(5):
        assert places(scene, initial_state(scene, seed=seed)) == {"blue": "left", "pink": "top", "green": "right"}


@pytest.mark.parametrize("location", ["san", "bin1", "bin2", "table"])
def test_every_slot_is_recognised(scene: Scene, arrange: Arrange, location: str) -> None:
    for slot in scene.slots[location]:
        data = arrange(pink=tuple(slot.position + [0.004, -0.004, CUBE_EDGE_M / 2 + 0.001]))
        assert slot_of(scene, true_poses(scene, data), "pink") is slot


@pytest.mark.parametrize(
    "pose",
    [
        pytest.param((0.62, 0.14, 0.0225), id="beside every location"),
        pytest.param((0.62, 0.20, 0.15), id="in the air above one"),
        pytest.param((0.62, 0.20, 0.031, 30), id="tilted"),
    ],
)
def test_an_object_out_of_place_has_none(scene: Scene, arrange: Arrange, pose: tuple[float, ...]) -> None:
    data = arrange(pink=pose)
    assert "pink" not in places(scene, data)


@pytest.mark.parametrize(("near", "far"), [("blue", "pink"), ("pink", "blue")])
def test_where_one_object_may_be_only_the_nearer_of_two_counts(
    scene: Scene, arrange: Arrange, near: str, far: str
) -> None:
    centre = scene.slots["san"][0].position + [0.0, 0.0, CUBE_EDGE_M / 2]
    found = places(scene, arrange(**{near: centre - [0.02, 0.0, 0.0], far: centre + [0.03, 0.0, 0.0]}))
    assert found == {near: "san", "green": "right"}


def test_nothing_rests_on_top_without_touching_a_support(scene: Scene, arrange: Arrange) -> None:
    top = scene.slots["top"][0].position + [0.0, 0.0, CUBE_EDGE_M / 2]
    assert "pink" not in places(scene, arrange(blue=(0.62, 0.20, 0.0225), green=(0.3, 0.2, 0.0225)))
    assert places(scene, arrange(pink=tuple(top)))["pink"] == "top"


def test_a_tower_is_recognised_storey_by_storey() -> None:
    scene = build_scene(TOWER)
    data = initial_state(scene, seed=1)
    assert places(scene, data) == {"one": "a", "two": "b", "three": "c"}


def test_what_is_held_rests_nowhere(scene: Scene, arrange: Arrange) -> None:
    state = observe(scene, arrange(), hand="home", held="pink")
    assert state.held == "pink" and "pink" not in state.place


def test_the_hand_is_where_it_was_sent_unless_it_is_not(scene: Scene, arrange: Arrange) -> None:
    data = arrange()
    q, _ = Arm(PANDA).reach([ToolPose.down(np.array([0.45, 0.30, 0.15]), np.pi / 2)])
    PANDA.put(data, q, width=0.0)
    mujoco.mj_forward(scene.mujoco, data)
    assert observe(scene, data, hand="san", held=None).hand == "san"
    assert observe(scene, data, hand="bin1", held=None).hand == "san"
    assert observe(scene, arrange(), hand="bin1", held=None).hand == NOWHERE


def test_a_hand_is_over_a_pile_however_low_the_objects_are() -> None:
    scene = build_scene(TOWER)
    data, nominal = initial_state(scene), scene.slots["b"][0].position
    pointing = ToolPose.down(nominal - [0.08, 0.0, 0.01], np.pi / 2).leaning(np.radians(85), np.array([-1.0, 0.0, 0.0]))
    q, _ = Arm(PANDA).reach(pointing.symmetric_poses())
    PANDA.put(data, q, width=0.0)
    mujoco.mj_forward(scene.mujoco, data)
    assert observe(scene, data, hand="b", held=None).hand == "b"


def test_marks_are_carried_over(scene: Scene, arrange: Arrange) -> None:
    assert observe(scene, arrange(), hand="home", held=None, marks=MARKS).marks == MARKS


def test_the_yaw_of_a_cube_is_known_up_to_a_quarter_turn(scene: Scene) -> None:
    data = initial_state(scene)
    for degrees in (0, 30, 100, 200):
        turn = np.radians(degrees)
        data.joint("pink").qpos[3:] = [np.cos(turn / 2), 0, 0, np.sin(turn / 2)]
        mujoco.mj_forward(scene.mujoco, data)
        yaw = object_pose(scene, data, "pink").yaw
        assert np.sin(2 * (yaw - turn)) == pytest.approx(0, abs=1e-6)


def test_equal_states_do_not_differ(scene: Scene, arrange: Arrange) -> None:
    data = arrange()
    state = observe(scene, data, hand="home", held=None)
    assert mismatch(scene, true_poses(scene, data), predicted=state, observed=state) is None


@pytest.mark.parametrize(
    ("predicted", "observed", "words"),
    [
        (("home", "pink", ()), ("home", None, (("pink", "top"),)), "expected pink in the hand, but it rests on top"),
        (("san", None, (("pink", "san"),)), ("san", "pink", ()), "expected pink on san, but it is in the hand"),
        (
            ("san", None, (("pink", "san"),)),
            ("san", None, ()),
            "expected pink on san, but it lies off every location, at (0.50, 0.00, 0.07) m",
        ),
        (("san", None, ()), ("bin1", None, ()), "expected the hand over san, but it is over bin1"),
        (("san", None, (), MARKS), ("san", None, ()), "expected blue to be sanitized"),
        (("san", None, ()), ("san", None, (), MARKS), "expected blue not to be sanitized"),
    ],
)
def test_a_mismatch_is_told_in_words(
    scene: Scene, arrange: Arrange, predicted: tuple, observed: tuple, words: str
) -> None:
    before, after = ManipulationState(*predicted), ManipulationState(*observed)
    assert mismatch(scene, true_poses(scene, arrange()), predicted=before, observed=after) == words
