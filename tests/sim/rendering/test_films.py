"""Cameras, qualities, and films made of finished ones."""

from __future__ import annotations

import typing
from dataclasses import replace
from pathlib import Path

import imageio_ffmpeg
import mediapy
import numpy as np
import pytest
from PIL import Image, ImageSequence

from experiments.cli.arguments import CAMERAS, QUALITIES
from experiments.commands.command_line import main
from sim.rendering import quality, renderer
from sim.rendering.cameras import SWING, Camera, camera
from sim.rendering.clips import GAP, compose
from sim.rendering.overlay import Caption, draw_caption
from sim.rendering.quality import DRAFT
from sim.rendering.video import render_frame
from sim.robots.panda import PANDA
from sim.world.scene import AZIMUTH, Scene, initial_state

SIZE = (160, 90)


def film(path: Path, shades: list[int]) -> Path:
    """Write a film of grey pictures, ten a second."""
    mediapy.set_ffmpeg(imageio_ffmpeg.get_ffmpeg_exe())
    mediapy.write_video(path, [np.full((90, 160, 3), shade, dtype=np.uint8) for shade in shades], fps=10, qp=10)
    return path


def pictures(path: Path) -> np.ndarray:
    reader = imageio_ffmpeg.read_frames(str(path))
    width, height = next(reader)["size"]  # type: ignore[index]
    return np.array([np.frombuffer(frame, dtype=np.uint8).reshape(height, width, 3) for frame in reader])  # type: ignore[arg-type]


@pytest.fixture
def films(tmp_path: Path) -> list[Path]:
    return [film(tmp_path / "long.mp4", [40] * 10 + [80] * 10), film(tmp_path / "short.mp4", [200] * 5 + [160] * 5)]


def test_the_command_line_offers_every_quality_and_camera() -> None:
    assert tuple(quality.QUALITIES) == QUALITIES
    assert typing.get_args(Camera) == CAMERAS


def test_the_orbit_begins_ends_and_turns_where_the_fixed_camera_is(scene: Scene) -> None:
    turns = [camera(scene, "orbit", share=share).azimuth - AZIMUTH for share in (0, 0.25, 0.5, 0.75, 1)]
    assert np.allclose(turns, [0, SWING, 0, -SWING, 0])
    assert camera(scene).azimuth == AZIMUTH


def test_the_wrist_sees_what_is_between_the_fingers(scene: Scene) -> None:
    data = initial_state(scene)
    eye = data.camera("wrist")
    ahead = -eye.xmat.reshape(3, 3)[:, 2]
    towards = data.site(PANDA.tool).xpos - eye.xpos
    assert ahead @ towards / np.linalg.norm(towards) > 0.98


def test_cameras_see_different_pictures(scene: Scene, gl: None) -> None:
    qpos = initial_state(scene).qpos
    fixed, wrist = (render_frame(scene, qpos, size=SIZE, camera=name) for name in ("fixed", "wrist"))
    assert fixed.shape == wrist.shape == (90, 160, 3)
    assert (abs(fixed.astype(int) - wrist) > 30).mean() > 0.3


def test_a_wide_lamp_sheds_softer_shadows_than_a_point(scene: Scene, gl: None, monkeypatch: pytest.MonkeyPatch) -> None:
    qpos = initial_state(scene).qpos
    pictures = []
    for radius in (0.0, 2 * renderer.LAMP_RADIUS):
        monkeypatch.setattr(renderer, "LAMP_RADIUS", radius)
        pictures.append(render_frame(scene, qpos, size=(480, 270), quality=replace(DRAFT, samples=5)).astype(float))
    hard, soft = (sum(float((np.diff(shown, axis=axis) ** 2).sum()) for axis in (0, 1)) for shown in pictures)
    assert soft < 0.985 * hard
    assert abs(pictures[0].mean() - pictures[1].mean()) < 1


def test_the_preference_stands_beside_the_cost() -> None:
    frames = [np.full((360, 640, 3), 128, dtype=np.uint8) for _ in range(2)]
    draw_caption(frames[0], Caption(0, 1, "grasp pink", 3, 34, ()))
    draw_caption(frames[1], Caption(0, 1, "grasp pink", 3, 34, (), 2, 7))
    changed = np.flatnonzero((frames[0] != frames[1]).any(axis=(0, 2)))
    assert len(changed) and changed.min() > 60 and changed.max() < 320


def test_films_stand_side_by_side_and_the_shorter_rests_on_its_last_picture(films: list[Path], tmp_path: Path) -> None:
    whole = pictures(compose(films, tmp_path / "both.mp4", height=90, fps=10))
    assert whole.shape == (20, 90, 320 + GAP, 3)
    left, right = whole[:, 45, 80, 0].astype(int), whole[:, 45, 244, 0].astype(int)
    assert abs(left - np.repeat([40, 80], 10)).max() < 6
    assert abs(right - np.array([200] * 5 + [160] * 15)).max() < 6


def test_headings_stand_over_their_films(films: list[Path], tmp_path: Path) -> None:
    bare = pictures(compose(films, tmp_path / "bare.mp4", height=90, fps=10))
    named = pictures(compose(films, tmp_path / "named.mp4", height=90, fps=10, headings=["first", "second"]))
    changed = (abs(bare.astype(int) - named) > 40).any(axis=(0, 3))
    assert changed[:20, :160].any() and changed[:20, 164:].any()
    assert not changed[30:].any()


@pytest.mark.parametrize("ending", ["gif", "webp"])
def test_a_short_film_for_a_page_is_quick_and_small(films: list[Path], tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"clip.{ending}"
    assert main(["film", str(films[0]), str(path), "--height", "45", "--speed", "2"]) == 0
    frames = [frame.convert("RGB") for frame in ImageSequence.Iterator(Image.open(path))]
    assert frames[0].size == (82, 46)
    shown = [np.asarray(frame)[20, 40, 0] for frame in frames]
    assert abs(int(shown[0]) - 40) < 8 and abs(int(shown[-1]) - 80) < 8
    assert path.stat().st_size < films[0].stat().st_size * 20


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["film", "no.mp4", "clip.gif"], "no.mp4: no such file"),
        (["film", "text.mp4", "clip.gif"], "text.mp4: cannot be read as a film"),
        (["film", "text.mp4", "clip.avi"], ".mp4, .gif, .webp"),
        (["film", "text.mp4", "clip.gif", "--speed", "0"], "stands still"),
    ],
)
def test_what_is_no_film_is_said_in_a_sentence(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("text.mp4").write_text("no film")
    assert main(arguments) == 2
    told = capsys.readouterr().err
    assert message in told and len(told.splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["text.mp4"]
