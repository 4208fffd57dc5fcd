"""Cameras: what is in the picture, how large, and where names are written."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import mujoco
import numpy as np
import pytest
from scenario_texts import shipped

from sim.errors import RenderingError
from sim.rendering.cameras import AZIMUTH_DEG, SWING_DEG, Camera, camera_names, label_offsets, read_view
from sim.rendering.framing import home_points, label_anchors, with_strays
from sim.rendering.labels import draw_labels, label_boxes
from sim.robots.arms.panda import PANDA
from sim.skills.hand import HOVER_HEIGHT_M
from sim.world.scene import Scene, build_scene, initial_state
from sim.world.shapes import CUBE_EDGE_M

SIZE = (1280, 612)
"""The picture over the captions of a video of 1280 x 720 pixels."""

HAND_M = (0.10, 0.03, 0.10)
"""The hand, from the tool along the closing direction, across it and upwards."""

FRAMES = 600
"""Of a video of 20 s, shorter than any of these scenes'."""

SCENES = ("case_study_3", "kitchen")


@pytest.fixture(scope="session")
def scenes() -> dict[str, Scene]:
    return {name: build_scene(shipped(name).model) for name in SCENES}


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
@pytest.mark.parametrize("camera, share", [("fixed", 0.0), *(("orbit", share) for share in (0.1, 0.25, 0.4, 0.75))])
@pytest.mark.parametrize("size", [SIZE, (720, 1280)])
def test_all_that_is_handled_stays_in_the_picture(
    scenes: dict[str, Scene], name: str, camera: str, share: float, size: tuple[int, int]
) -> None:
    pixels = Camera(scenes[name], camera, size).pixels(handled(scenes[name]), share)
    assert (pixels > 0).all() and (pixels < size).all()


@pytest.mark.parametrize("name", SCENES)
def test_the_camera_draws_near_from_where_it_sees_the_hand_at_home(scenes: dict[str, Scene], name: str) -> None:
    scene, points = scenes[name], handled(scenes[name])
    camera = Camera(scene, "fixed", SIZE, opening=0.1)
    shares = np.linspace(0.0, 0.1, 6)
    for share in shares:
        pixels = camera.pixels(points, share)
        assert (pixels > 0).all() and (pixels < SIZE).all()
    hand = camera.pixels(home_points(scene))
    assert (hand > 0).all() and (hand < SIZE).all()
    widths = [np.ptp(camera.pixels(points, share)[:, 0]) for share in shares]
    assert (np.diff(widths) > 0).all()
    assert np.allclose(camera.pixels(points, 0.1), Camera(scene, "fixed", SIZE).pixels(points))


def test_an_object_that_lies_off_every_location_is_in_the_picture(scenes: dict[str, Scene]) -> None:
    scene = build_scene(scenes["case_study_3"].model, spares=2)
    states = np.tile(initial_state(scene).qpos, (5, 1))
    assert with_strays(scene, states).slots == scene.slots
    blue = scene.mujoco.joint("blue").qposadr[0]
    states[:, blue : blue + 3] = [[0.5, 0.03, 0.0225], [0.4, 0.3, 0.2], *[[0.7, -0.42, 0.0225]] * 2, [2, 2, -0.5]]
    moved = with_strays(scene, states)
    assert [np.allclose(moved.slots[name][0].position, [0.7, -0.42, 0.0]) for name in moved.temporary] == [True]
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


def anchors_in(scene: Scene, camera: Camera, share: float) -> dict[str, np.ndarray]:
    places = label_anchors(scene)
    return dict(zip(places, camera.pixels(np.array([*places.values()]), share), strict=True))


@pytest.mark.parametrize("name", SCENES)
def test_names_go_with_their_locations_as_the_camera_turns(scenes: dict[str, Scene], name: str) -> None:
    scene, camera = scenes[name], Camera(scenes[name], "orbit", SIZE)
    offsets = label_offsets(scene, camera)
    anchors = [anchors_in(scene, camera, share) for share in np.arange(0.0, 1.0, 1 / FRAMES)]
    boxes = [label_boxes(shown, offsets, SIZE) for shown in anchors]
    for label in offsets:
        turned, moved = (abs(np.diff([shown[label][:2] for shown in frames], axis=0)) for frames in (anchors, boxes))
        # At the edge of the picture a name stays; elsewhere it goes as far, to a pixel.
        assert turned.max() > 2 and (moved <= turned + 1).all()


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("share", [0.0, 0.1, 0.25, 0.4, 0.75])
def test_every_name_is_in_the_picture_and_none_overlaps_another(
    scenes: dict[str, Scene], name: str, share: float
) -> None:
    scene, camera = scenes[name], Camera(scenes[name], "orbit", SIZE)
    placed = label_boxes(anchors_in(scene, camera, share), label_offsets(scene, camera), SIZE)
    assert placed.keys() == shown_in(scene)
    for left, top, right, bottom in placed.values():
        assert 0 <= left < right <= SIZE[0] and 0 <= top < bottom <= SIZE[1] and bottom - top >= 20
    for a, b in combinations(placed.values(), 2):
        assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]


def test_the_orbit_begins_ends_and_turns_where_the_fixed_camera_is(scenes: dict[str, Scene]) -> None:
    scene = scenes["case_study_3"]
    orbit = Camera(scene, "orbit", SIZE)
    turns = [orbit.view(share).azimuth - AZIMUTH_DEG for share in (0, 0.25, 0.5, 0.75, 1)]
    assert np.allclose(turns, [0, SWING_DEG, 0, -SWING_DEG, 0])
    assert Camera(scene, "fixed", SIZE).view(0.25).azimuth == AZIMUTH_DEG


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


def test_a_line_to_a_location_does_not_come_and_go_as_the_camera_moves() -> None:
    frame, target = np.zeros((*SIZE[::-1], 3), np.uint8), np.array([100.0, 100.0])
    for heights, with_line in ((1.5, False), (2.0, True)):
        for at in np.linspace(0.0, 2.0, 9):
            anchor = {"stove": np.array([400.0, 300.0]) + at}
            (left, top, right, bottom) = label_boxes(anchor, {"stove": np.zeros(2)}, SIZE)["stove"]
            offset = {"stove": np.array([0.0, heights * (bottom - top)])}
            drawn = draw_labels(frame, label_boxes(anchor, offset, SIZE), anchor, {"stove": target})
            assert bool(drawn[100, 100].any()) == with_line, (heights, at)


def test_a_camera_may_be_anywhere(scenes: dict[str, Scene]) -> None:
    view = Camera(scenes["case_study_3"], "90, -45,2.5", SIZE).view()
    assert (view.azimuth, view.elevation, view.distance) == (90, -45, 2.5)
    assert read_view("-10,-90,1") == (-10, -90, 1)


def test_a_camera_of_the_mjcf_is_chosen_by_its_name() -> None:
    def watched() -> mujoco.MjSpec:
        spec = PANDA.mjcf()
        spec.worldbody.add_camera(name="door", pos=[2.0, 0.0, 1.0])
        return spec

    scene = build_scene(shipped("case_study_3").model, robot=replace(PANDA, mjcf=watched))
    assert camera_names(scene) == ("fixed", "orbit", "wrist", "top", "door")
    door = Camera(scene, "door", SIZE)
    assert door.mounted and door.view().fixedcamid == scene.mujoco.camera("door").id


@pytest.mark.parametrize("text", ["above", "1,2", "1,2,3,4", "1,2,x", "0,-100,1", "0,0,0", "0,0,nan", "nan,0,1"])
def test_a_camera_that_cannot_be_is_refused(text: str) -> None:
    with pytest.raises(RenderingError, match=text):
        read_view(text)
