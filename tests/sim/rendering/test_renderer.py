"""Pictures: cameras, glowing lamps, smooth edges, and machines without OpenGL."""

from __future__ import annotations

import copy
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import binary_erosion, map_coordinates, median_filter

from prefplan.models.manipulation.model import Location, ManipulationModel
from sim.errors import RenderingError
from sim.rendering import antialias, renderer, video
from sim.rendering.antialias import smooth_edges
from sim.rendering.opengl import CURE, check_rendering, gl_backend
from sim.rendering.quality import DRAFT
from sim.rendering.video import render_frame, render_video
from sim.world.scene import Scene, build_scene, initial_state

SIZE = (160, 90)
SMALL = replace(DRAFT, size=SIZE)
PACKAGES = "libegl1 libegl-mesa0 libgl1-mesa-dri"


@pytest.fixture(scope="session")
def picture(scene: Scene, gl: None) -> np.ndarray:
    """The start of Case Study 3."""
    return render_frame(scene, initial_state(scene).qpos, quality=SMALL).astype(int)


def test_cameras_see_different_pictures(scene: Scene, picture: np.ndarray) -> None:
    wrist = render_frame(scene, initial_state(scene).qpos, quality=SMALL, camera="wrist")
    assert picture.shape == wrist.shape == (90, 160, 3) and picture.std() > 20
    assert (abs(picture - wrist) > 30).mean() > 0.3


def test_a_wide_lamp_sheds_softer_shadows_than_a_point(scene: Scene, gl: None) -> None:
    qpos = initial_state(scene).qpos
    pictures = []
    for radius in (0.0, 2 * DRAFT.lamp_radius_rad):
        quality = replace(DRAFT, samples=5, lamp_radius_rad=radius)
        pictures.append(render_frame(scene, qpos, quality=replace(quality, size=(480, 270))).astype(float))
    hard, soft = (sum(float((np.diff(shown, axis=axis) ** 2).sum()) for axis in (0, 1)) for shown in pictures)
    assert soft < 0.985 * hard
    assert abs(pictures[0].mean() - pictures[1].mean()) < 1


def test_the_lit_table_has_no_specks_of_shadow(scene: Scene, gl: None) -> None:
    bare = replace(scene, mujoco=copy.copy(scene.mujoco))
    bare.mujoco.mat("studio_outline").rgba[3] = 0  # outlines shade the table
    unshadowed = replace(bare, mujoco=copy.copy(bare.mujoco))
    unshadowed.mujoco.light_castshadow[:] = False
    lit, plain = (
        render_frame(one, initial_state(scene).qpos, quality=replace(DRAFT, size=(960, 540), samples=5)).astype(float)
        for one in (bare, unshadowed)
    )
    light = lit.sum(axis=2) / plain.sum(axis=2)
    wood = plain[..., 0] > plain[..., 2] + 25
    around = median_filter(light, 7)
    plane = binary_erosion(wood & (abs(around - np.median(light[wood])) < 0.02), iterations=4)
    assert plane.mean() > 0.2
    # Without `fill_specks`, 0.0011 with Mesa's software renderer.
    assert (light - around < -0.03)[plane].mean() < 1e-4


def test_smoothing_softens_a_slanted_edge_and_leaves_flat_areas() -> None:
    rows, columns = np.mgrid[:60, :90]
    frame = np.repeat(np.where(columns < 40 + rows / 5, 30, 200).astype(np.uint8)[..., None], 3, axis=2)
    smooth = smooth_edges(frame)
    edge = abs(columns - 40 - rows / 5) < 2
    assert (smooth[~edge] == frame[~edge]).all()
    assert ((smooth[edge] > 60) & (smooth[edge] < 170)).any()


def test_edges_are_blended_as_scipy_interpolates() -> None:
    frame = np.random.default_rng(0).integers(0, 256, (30, 40, 3), dtype=np.uint8)
    pixels, greys, at = antialias._without_specks(frame)
    shade = greys.astype(float)
    upper_left, upper_right, lower_left, lower_right = (
        np.roll(shade, (-down, -right), (0, 1)).ravel()[at] for down in (-1, 1) for right in (-1, 1)
    )
    along = np.array(
        [lower_left + upper_left - lower_right - upper_right, lower_left + lower_right - upper_left - upper_right]
    )
    bright = upper_left + upper_right + lower_left + lower_right
    along = np.clip(along / (abs(along).min(axis=0) + np.maximum(bright / 32, 2)), -8, 8)
    places = [np.array(np.divmod(at, 40)) + share * along for share in (-0.4, 0.0, 0.4)]
    expected = pixels.astype(float).reshape(-1, 3)
    expected[at] = np.mean(
        [
            [map_coordinates(pixels[..., i].astype(float), place, order=1, mode="nearest") for i in range(3)]
            for place in places
        ],
        axis=0,
    ).T
    assert len(at) > 500
    assert abs(smooth_edges(frame).reshape(-1, 3) - expected).max() <= 1


def test_smoothing_fills_in_dark_specks() -> None:
    frame = np.full((20, 20, 3), 200, dtype=np.uint8)
    frame[10, 7] = frame[14, 3] = frame[15, 4] = 40
    assert (smooth_edges(frame) == 200).all()


def test_a_frame_shows_the_lamp_at_work(scene: Scene, picture: np.ndarray) -> None:
    difference = render_frame(scene, initial_state(scene).qpos, glow=("san",), quality=SMALL) - picture
    assert difference[..., 2].max() > 60
    assert (difference == 0).mean() > 0.5


def test_a_stove_glows_red_while_it_works(gl: None) -> None:
    costs = dict.fromkeys(("transit", "grasp", "transport", "release"), 1)
    stove = Location("stove", at=(0.5, 0.0), kind="stove", marks="cooked")
    scene = build_scene(ManipulationModel("home", costs, (stove,), ()))
    dark, lit = (render_frame(scene, initial_state(scene).qpos, glow=glow, quality=SMALL) for glow in ((), ("stove",)))
    red, _, blue = np.moveaxis(lit.astype(int) - dark, -1, 0)
    assert red.max() > 60 and red.max() > 2 * blue.max()


@pytest.mark.parametrize("wanted", ["egl", "off"])
def test_a_machine_without_gl_is_told_what_mends_it_in_one_sentence(
    wanted: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", wanted)
    monkeypatch.setenv("PYOPENGL_PLATFORM", "none")
    with pytest.raises(RenderingError, match=PACKAGES) as caught:
        check_rendering()
    assert "\n" not in str(caught.value) and CURE in str(caught.value) and "unset MUJOCO_GL" in str(caught.value)


def test_without_gl_there_is_no_picture_and_of_a_video_that_fails_nothing_is_left(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def refuse(*_: Any) -> Any:
        raise ImportError("no EGL")

    qpos = initial_state(scene).qpos
    monkeypatch.setattr(renderer, "gl_context", refuse)
    with pytest.raises(RenderingError, match=PACKAGES) as caught:
        render_frame(scene, qpos)

    def fail(jobs: Any, workers: int) -> Any:
        raise caught.value

    monkeypatch.setattr(video, "_in_processes", fail)
    rollout: Any = SimpleNamespace(times=np.zeros(1), qpos=qpos[None], glow=-np.ones(1))
    with pytest.raises(RenderingError, match=PACKAGES):
        render_video(scene, rollout, (), tmp_path / "out" / "video.mp4")
    assert list((tmp_path / "out").iterdir()) == []


def test_a_backend_the_user_chose_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setenv("MUJOCO_GL", "osmesa")
    assert gl_backend() == "osmesa"
    monkeypatch.delenv("MUJOCO_GL")
    assert gl_backend() == ""
    monkeypatch.delenv("DISPLAY")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert gl_backend() == "egl"
