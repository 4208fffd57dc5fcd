"""A second view in a corner of the picture."""

from __future__ import annotations

import numpy as np
import pytest
from scenario_texts import shipped

from sim.rendering.cameras import Camera, label_offsets
from sim.rendering.framing import hand_corners, label_anchors, object_corners
from sim.rendering.inset import inset_box
from sim.rendering.labels import label_boxes
from sim.rendering.video import render_frame
from sim.world.scene import Scene, build_scene, initial_state

SIZE = (1280, 612)


@pytest.mark.parametrize("name", ["case_study_3", "kitchen"])
def test_an_inset_covers_nothing_that_is_handled_nor_the_hand_nor_a_name(name: str) -> None:
    scene = build_scene(shipped(name).model, meshes=False)
    camera = Camera(scene, "fixed", SIZE)
    inset = left, top, right, bottom = inset_box(scene, camera)
    assert (left in (0, SIZE[0] - (right - left))) and (top in (0, SIZE[1] - (bottom - top)))
    seen = [camera.pixels(box) for box in np.concatenate([object_corners(scene), hand_corners(scene)])]
    anchors = {label: camera.pixels(point[None])[0] for label, point in label_anchors(scene).items()}
    names = label_boxes(anchors, label_offsets(scene, camera, inset=inset), SIZE).values()
    for low_x, low_y, high_x, high_y in [*names, *((*points.min(axis=0), *points.max(axis=0)) for points in seen)]:
        assert high_x <= left or low_x >= right or high_y <= top or low_y >= bottom


def test_an_inset_shows_another_view_and_leaves_the_rest(scene: Scene, gl: None) -> None:
    qpos, size = initial_state(scene).qpos, (320, 180)
    plain, both = (render_frame(scene, qpos, size=size, camera=camera) for camera in ("wrist", "wrist+top"))
    left, top, right, bottom = inset_box(scene, Camera(scene, "wrist", size))
    changed = (plain != both).any(axis=2)
    assert changed[top:bottom, left:right].mean() > 0.8
    changed[top:bottom, left:right] = False
    assert not changed.any()
    small = render_frame(scene, qpos, size=(right - left, bottom - top), camera="top").astype(int)
    middle = np.s_[2:-2, 2:-2]
    assert abs(both[top:bottom, left:right].astype(int) - small)[middle].mean() < 20
