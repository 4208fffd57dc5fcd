"""Cameras: what is in the picture, how large, and where names are written."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import mujoco
import numpy as np
import pytest
from scenario_texts import shipped

from sim.errors import RenderingError
from sim.rendering.cameras import Camera, camera_names, read_view
from sim.rendering.framing import label_anchors, object_corners, with_strays
from sim.rendering.labels import drawn_labels, place_labels
from sim.robots.arms.panda import PANDA
from sim.skills.hand import HOVER_HEIGHT_M
from sim.world.scene import Scene, build_scene, initial_state
from sim.world.shapes import CUBE_EDGE_M

SIZE = (1280, 612)
"""The picture over the captions of a video of 1280 x 720 pixels."""

HAND_M = (0.10, 0.03, 0.10)
"""The hand, from the tool along the closing direction, across it and upwards."""

SCENES = ("case_study_3", "kitchen")


@pytest.fixture(scope="session")
def scenes() -> dict[str, Scene]:
    return {name: build_scene(shipped(name).model, meshes=False) for name in SCENES}


def box(middle: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    ends = np.stack([low, high])
    return np.array([middle + ends[[i, j, k], [0, 1, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])


def handled(scene: Scene) -> np.ndarray:
    """Return the corners of the highest object in every slot, and of the hand that hovers over it."""
    height = max(shape.height for shape in scene.shapes.values())
    points = []
    for slot in (slot for row in scene.slots.values() for slot in row):
        middle = slot.position + [0.0, 0.0, height / 2]
        points.append(box(middle, np.full(3, -0.02), np.array([0.02, 0.02, height / 2])))
        along = np.array([np.cos(slot.yaw), np.sin(slot.yaw), 0.0])
        turned = np.array([along, np.cross([0.0, 0.0, 1.0], along), [0.0, 0.0, 1.0]])
        hand = box(np.zeros(3), -np.array([*HAND_M[:2], 0.0]), np.array(HAND_M)) @ turned
        points.append(middle + [0.0, 0.0, HOVER_HEIGHT_M] + hand)
    return np.concatenate(points)


def narrowest_cube(scene: Scene, camera: Camera) -> float:
    half = np.full(3, CUBE_EDGE_M / 2)
    cubes = [box(slot.position + half * [0, 0, 1], -half, half) for row in scene.slots.values() for slot in row]
    return min(float(np.ptp(camera.pixels(cube)[:, 0])) for cube in cubes)


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("camera", ["fixed", "top"])
@pytest.mark.parametrize("size", [SIZE, (720, 1280)])
def test_all_that_is_handled_stays_in_the_picture(
    scenes: dict[str, Scene], name: str, camera: str, size: tuple[int, int]
) -> None:
    pixels = Camera(scenes[name], camera, size).pixels(handled(scenes[name]))
    assert (pixels > 0).all() and (pixels < size).all()


def test_an_object_that_lies_off_every_location_is_in_the_picture(scenes: dict[str, Scene]) -> None:
    scene = build_scene(scenes["case_study_3"].model, meshes=False, spares=2)
    states = np.tile(initial_state(scene).qpos, (5, 1))
    assert with_strays(scene, states).slots == scene.slots
    blue = scene.mujoco.joint("blue").qposadr[0]
    states[:, blue : blue + 3] = [[0.5, 0.03, 0.0225], [0.4, 0.3, 0.2], *[[0.25, 0.42, 0.0225]] * 2, [2, 2, -0.5]]
    moved = with_strays(scene, states)
    assert [np.allclose(moved.slots[name][0].position, [0.25, 0.42, 0.0]) for name in moved.temporary] == [True]
    before, after = (Camera(shown, "fixed", SIZE) for shown in (scene, moved))
    inside = [((pixels > 0) & (pixels < SIZE)).all() for pixels in (c.pixels(handled(moved)) for c in (before, after))]
    assert inside == [False, True]
    assert label_anchors(moved).keys() == shown_in(scene)


@pytest.mark.parametrize("name, least_px", [("case_study_3", 60), ("kitchen", 45)])
def test_a_cube_is_large_in_the_picture(scenes: dict[str, Scene], name: str, least_px: float) -> None:
    assert narrowest_cube(scenes[name], Camera(scenes[name], "fixed", SIZE)) >= least_px


def shown_in(scene: Scene) -> set[str]:
    """Return what people are shown for the locations."""
    return set(map(scene.model.display.location, scene.slots))


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("camera", ["fixed", "top", "90,-30,1.4"])
def test_every_name_is_in_the_picture_and_none_overlaps_another(
    scenes: dict[str, Scene], name: str, camera: str
) -> None:
    scene, seen = scenes[name], Camera(scenes[name], camera, SIZE)
    places, corners = label_anchors(scene), seen.pixels(object_corners(scene).reshape(-1, 3)).reshape(-1, 8, 2)
    anchors = dict(zip(places, seen.pixels(np.array([*places.values()])), strict=True))
    placed = place_labels(anchors, np.hstack([corners.min(axis=1), corners.max(axis=1)]), SIZE)
    assert placed.keys() == shown_in(scene)
    for left, top, right, bottom in placed.values():
        assert 0 <= left < right <= SIZE[0] and 0 <= top < bottom <= SIZE[1] and bottom - top >= 20
    for a, b in combinations(placed.values(), 2):
        assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]


def test_the_wrist_sees_what_is_between_the_fingers_from_above(scenes: dict[str, Scene]) -> None:
    data = initial_state(scenes["case_study_3"])
    eye = data.camera("wrist")
    axes = eye.xmat.reshape(3, 3)
    tool = data.site(PANDA.tool)
    towards = tool.xpos - eye.xpos
    assert -axes[:, 2] @ towards / np.linalg.norm(towards) > 0.98
    assert axes[2, 1] > 0, "upside down"
    # Past the palm, 3 cm to the side of the tool and 4 cm above it.
    edge = tool.xpos + tool.xmat.reshape(3, 3) @ [0.03, 0.0, -0.045] - eye.xpos
    assert np.arctan2(edge @ axes[:, 1], -edge @ axes[:, 2]) > np.radians(8)


def test_a_name_that_is_far_from_its_anchor_has_a_line_to_its_location() -> None:
    anchor, target = {"stove": np.array([400.0, 300.0])}, {"stove": np.array([100.0, 100.0])}
    for far, with_line in ((20, False), (60, True)):
        box = {"stove": (350, 300 + far, 450, 330 + far)}
        drawn = np.asarray(drawn_labels(box, anchor, target, SIZE))
        assert bool(drawn[100, 100, 3]) == with_line and drawn[315 + far, 400, 3]


def test_a_camera_may_be_anywhere(scenes: dict[str, Scene]) -> None:
    view = Camera(scenes["case_study_3"], "90, -45,2.5", SIZE).view
    assert (view.azimuth, view.elevation, view.distance) == (90, -45, 2.5)
    assert read_view("-10,-90,1") == (-10, -90, 1)


def test_a_camera_of_the_mjcf_is_chosen_by_its_name() -> None:
    def watched(meshes: bool | None) -> mujoco.MjSpec:
        spec = PANDA.mjcf(meshes)
        spec.worldbody.add_camera(name="door", pos=[2.0, 0.0, 1.0])
        return spec

    scene = build_scene(shipped("case_study_3").model, robot=replace(PANDA, mjcf=watched), meshes=False)
    assert camera_names(scene) == ("fixed", "wrist", "top", "door")
    door = Camera(scene, "door", SIZE)
    assert door.mounted and door.view.fixedcamid == scene.mujoco.camera("door").id


@pytest.mark.parametrize("text", ["above", "1,2", "1,2,3,4", "1,2,x", "0,-100,1", "0,0,0", "0,0,nan", "nan,0,1"])
def test_a_camera_that_cannot_be_is_refused(text: str) -> None:
    with pytest.raises(RenderingError, match=text):
        read_view(text)
