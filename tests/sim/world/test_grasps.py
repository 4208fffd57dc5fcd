"""Grasps derived from shapes alone, and orientations in which shapes look the same."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from prefplan.models.manipulation.model import Object
from sim.perception.sensors import ObjectPose
from sim.robots.arms.panda import PANDA
from sim.world.grasps import GraspPose, grasps
from sim.world.shapes import ObjectShape, about_z, shape_of

SHAPES = {
    "cube": Object("x", "spot"),
    "box": Object("x", "spot", kind="box", size=(0.075, 0.045, 0.03)),
    "long box": Object("x", "spot", kind="box", size=(0.12, 0.03, 0.03)),
    "can": Object("x", "spot", kind="cylinder", size=(0.03, 0.06)),
    "disc": Object("x", "spot", kind="cylinder", size=(0.06, 0.03)),
}
HIGH = {
    "high box": Object("x", "spot", kind="box", size=(0.05, 0.04, 0.09)),
    "high can": Object("x", "spot", kind="cylinder", size=(0.055, 0.10)),
}
LYING = Rotation.from_euler("y", 90, degrees=True).as_matrix()


@pytest.fixture(params=SHAPES)
def shape(request: pytest.FixtureRequest) -> ObjectShape:
    return shape_of(SHAPES[request.param], PANDA.gripper)


def tilt(steepness: float) -> float:
    return float(np.degrees(np.arccos(np.clip(-steepness, -1, 1))))


def tilts(grasp: GraspPose, shape: ObjectShape, before: np.ndarray) -> tuple[float, float]:
    """Return how far the hand is tilted where the object lies, and where it stands at best, degrees."""
    after = [tilt((up @ grasp.rotation)[2, 2]) for up in shape.symmetries]
    return tilt((before @ grasp.rotation)[2, 2]), min(after)


def test_the_hand_comes_from_above_first_and_closes_along_the_first_line(shape: ObjectShape) -> None:
    found = grasps(shape, PANDA.gripper)
    first = found[0]
    assert first.rotation[:, 2] == pytest.approx([0, 0, -1]) and abs(first.rotation[0, 1]) == pytest.approx(1)
    assert first.clearance is None and first.position == pytest.approx(np.zeros(3))
    steep = [tilt(grasp.rotation[2, 2]) for grasp in found]
    assert np.diff(steep).min() > -1e-4 and steep[-1] > 150


def test_pads_meet_the_object_and_the_palm_does_not(shape: ObjectShape) -> None:
    for grasp in grasps(shape, PANDA.gripper):
        assert grasp.rotation.T @ grasp.rotation == pytest.approx(np.eye(3)) and np.linalg.det(grasp.rotation) > 0
        assert 2 * shape.support(grasp.rotation[:, 1]) == pytest.approx(grasp.width)
        assert grasp.width < grasp.opening <= PANDA.gripper.opening_m
        approach = grasp.rotation[:, 2]
        assert shape.support(-approach) + grasp.position @ approach < 0.0374, "the palm is 37.4 mm from the tool"


def test_what_looks_the_same_is_taken_the_same_way(shape: ObjectShape) -> None:
    found = {tuple(np.round(grasp.rotation[:, 2], 6) + 0.0) for grasp in grasps(shape, PANDA.gripper)}
    for turn in shape.symmetries:
        assert {tuple(np.round(turn @ approach, 6) + 0.0) for approach in found} == found


@pytest.mark.parametrize("name", ["can", "disc", "box", *HIGH])
def test_a_tilted_hand_takes_what_lies_and_sets_it_upright(name: str) -> None:
    shape = shape_of((SHAPES | HIGH)[name], PANDA.gripper)
    lying = LYING if shape.is_round else Rotation.from_euler("x", 90, degrees=True).as_matrix()
    best = min(max(tilts(grasp, shape, lying)) for grasp in grasps(shape, PANDA.gripper))
    assert best == pytest.approx(45)


@pytest.mark.parametrize(("name", "count"), [("cube", 24), ("long box", 8), ("box", 4), ("can", 2)])
def test_symmetries_turn_a_shape_into_itself(name: str, count: int) -> None:
    shape = shape_of(SHAPES[name], PANDA.gripper)
    assert len(shape.symmetries) == count and shape.symmetries[0] == pytest.approx(np.eye(3))
    assert np.linalg.det(shape.symmetries) == pytest.approx(np.ones(count))
    for direction in np.eye(3):
        assert [shape.support(turn @ direction) for turn in shape.symmetries] == pytest.approx(
            [shape.support(direction)] * count
        )


@pytest.mark.parametrize(
    ("name", "axis", "upright"),
    [
        ("cube", "x", True),
        ("long box", "y", True),
        ("long box", "x", False),
        ("box", "x", False),
        ("can", "y", False),
    ],
)
def test_a_face_with_which_it_is_as_high_as_before_is_as_good(name: str, axis: str, upright: bool) -> None:
    # The long box closes along its short side, which is its x axis: it rolls about its y axis.
    rotation = about_z(0.3) @ Rotation.from_euler(axis, 90, degrees=True).as_matrix()
    assert ObjectPose(shape_of(SHAPES[name], PANDA.gripper), np.zeros(3), rotation).is_upright == upright


def test_what_is_round_has_no_heading_along_its_axis() -> None:
    shape, standing = shape_of(SHAPES["can"], PANDA.gripper), about_z(0.3)
    assert np.array_equal(shape.heading_to(standing, np.zeros(3)), standing)
    assert shape.heading_to(standing, np.array([0.0, 2.0, 1.0]))[:, 0] == pytest.approx([0.0, 1.0, 0.0])
