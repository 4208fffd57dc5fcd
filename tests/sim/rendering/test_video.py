from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest

from prefplan.models.manipulation.model import Location, ManipulationModel
from sim.errors import RenderingError
from sim.rendering.antialias import smooth_edges
from sim.rendering.overlay import Caption, TaskStatus, caption_at, draw_caption
from sim.rendering.renderer import CURE, check_rendering, gl_environment
from sim.rendering.video import LAST_FRAME, render_frame, render_video
from sim.simulation.rollout import FRAME_RATE, Rollout
from sim.world.scene import Scene, build_scene, initial_state

SIZE = (320, 180)
PACKAGES = "libegl1 libegl-mesa0 libgl1-mesa-dri"


@pytest.fixture
def captions() -> tuple[Caption, ...]:
    tasks = (TaskStatus("phi1", "F blue_bin1", "open"), TaskStatus("phi2", "F pink_bin1", "satisfied"))
    return (Caption(0.0, 1.0, "transit top", 3, 34, tasks), Caption(1.0, 2.0, "grasp pink", 4, 34, tasks))


@pytest.fixture
def rollout(scene: Scene) -> Rollout:
    frames = 3 * FRAME_RATE
    qpos = np.tile(initial_state(scene).qpos, (frames, 1))
    qpos[:, 0] = np.linspace(0, 0.8, frames)
    times = np.arange(frames) / FRAME_RATE
    places = [place.name for place in scene.model.locations]
    return Rollout(
        completed=True,
        reason=None,
        steps=(),
        events=(),
        times=times,
        qpos=qpos,
        glow=np.where(times > 1.0, places.index("san"), -1),
        speeds=np.zeros((frames, 7)),
        torques=np.zeros((frames, 7)),
        margins=np.zeros((frames, 7)),
        pad_forces=np.zeros((frames, 2)),
        sim_seconds=float(times[-1]),
        wall_seconds=0.0,
        placement_error=0.0,
        robot=scene.robot,
    )


def run_without_gl(code: str) -> subprocess.CompletedProcess[str]:
    environment = gl_environment() | {"MUJOCO_GL": "egl", "PYOPENGL_PLATFORM": "none"}
    return subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)


def test_a_caption_is_shown_until_the_next_one_starts(captions: tuple[Caption, ...]) -> None:
    assert caption_at(captions, -0.1) is None
    assert caption_at(captions, 0.0) is captions[0]
    assert caption_at(captions, 0.999) is captions[0]
    assert caption_at(captions, 1.0) is captions[1]
    assert caption_at(captions, 99.0) is captions[1]
    assert caption_at((), 1.0) is None


def test_a_caption_covers_the_lower_third_only(captions: tuple[Caption, ...]) -> None:
    frame = np.full((720, 1280, 3), 128, dtype=np.uint8)
    draw_caption(frame, captions[0])
    assert (frame[:480] == 128).all()
    assert frame[-40:].mean() < 64
    assert frame.max() > 220


def test_states_of_tasks_and_spent_cost_can_be_told_apart(captions: tuple[Caption, ...]) -> None:
    frames = [np.full((720, 1280, 3), 128, dtype=np.uint8) for _ in range(2)]
    done = tuple(TaskStatus(task.name, task.text, "satisfied") for task in captions[0].tasks)
    draw_caption(frames[0], captions[0])
    draw_caption(frames[1], Caption(0.0, 1.0, "transit top", 30, 34, done))
    changed = (frames[0] != frames[1]).any(axis=(0, 2))
    assert changed[:400].any() and changed[500:].any()


@pytest.mark.parametrize("text", ["", "F a & " * 80])
def test_a_long_formula_is_cut_at_the_margin(text: str) -> None:
    frame = np.full((360, 640, 3), 128, dtype=np.uint8)
    draw_caption(frame, Caption(0, 1, "release blue bin1", 0, 0, (TaskStatus("phi1", text, "open"),)))
    bare = np.full_like(frame, 128)
    draw_caption(bare, Caption(0, 1, "release blue bin1", 0, 0, ()))
    assert (frame[:, -16:] == bare[:, -16:]).all()


def test_smoothing_softens_a_slanted_edge_and_leaves_flat_areas() -> None:
    rows, columns = np.mgrid[:60, :90]
    frame = np.repeat(np.where(columns < 40 + rows / 5, 30, 200).astype(np.uint8)[..., None], 3, axis=2)
    smooth = smooth_edges(frame)
    edge = abs(columns - 40 - rows / 5) < 2
    assert (smooth[~edge] == frame[~edge]).all()
    between = (smooth[edge] > 60) & (smooth[edge] < 170)
    assert between.any()


def test_smoothing_fills_in_dark_specks() -> None:
    frame = np.full((20, 20, 3), 200, dtype=np.uint8)
    frame[10, 7] = frame[14, 3] = frame[15, 4] = 40
    assert (smooth_edges(frame) == 200).all()


def test_a_frame_shows_the_lamp_at_work(scene: Scene, gl: None) -> None:
    qpos = initial_state(scene).qpos
    dark, lit = (render_frame(scene, qpos, glow=glow, size=SIZE) for glow in ((), ("san",)))
    assert dark.shape == (180, 320, 3) and dark.dtype == np.uint8
    assert dark.std() > 20
    difference = lit.astype(int) - dark
    assert difference[..., 2].max() > 60
    assert (difference == 0).mean() > 0.5


def test_a_stove_glows_red_while_it_works(gl: None) -> None:
    costs = dict.fromkeys(("transit", "grasp", "transport", "release"), 1)
    stove = Location("stove", at=(0.5, 0.0), kind="stove", marks="cooked")
    scene = build_scene(ManipulationModel("home", costs, (stove,), ()), meshes=False)
    dark, lit = (render_frame(scene, initial_state(scene).qpos, glow=glow, size=SIZE) for glow in ((), ("stove",)))
    red, _, blue = np.moveaxis(lit.astype(int) - dark, -1, 0)
    assert red.max() > 60 and red.max() > 2 * blue.max()


def test_a_robot_without_meshes_can_be_filmed_too(scene: Scene, gl: None) -> None:
    plain = build_scene(scene.model, meshes=False)
    dressed, bare = (render_frame(s, initial_state(s).qpos, size=SIZE).astype(int) for s in (scene, plain))
    assert 0 < (abs(dressed - bare).max(axis=2) > 20).mean() < 0.3


@pytest.mark.slow
@pytest.mark.parametrize("processes", [1, 2])
def test_a_video_holds_every_frame(
    scene: Scene, rollout: Rollout, captions: tuple[Caption, ...], gl: None, tmp_path: Path, processes: int
) -> None:
    told: list[tuple[int, int]] = []
    path = render_video(
        scene,
        rollout,
        captions,
        tmp_path / "new" / "film.mp4",
        size=SIZE,
        processes=processes,
        progress=lambda done, total: told.append((done, total)),
    )
    frames = round((rollout.times[-1] + LAST_FRAME) * 30) + 1
    assert imageio_ffmpeg.count_frames_and_secs(str(path))[0] == frames
    assert told[-1] == (frames, frames)
    reader = imageio_ffmpeg.read_frames(str(path))
    meta = next(reader)
    assert meta["codec"] == "h264" and meta["fps"] == 30 and meta["source_size"] == SIZE
    pictures = [np.frombuffer(data, np.uint8).reshape(180, 320, 3).astype(int) for data in reader]
    assert abs(pictures[0] - pictures[60]).max() > 100
    assert abs(pictures[-1] - pictures[-20]).mean() < 2
    assert [entry.name for entry in path.parent.iterdir()] == ["film.mp4"]


def test_a_video_that_fails_leaves_nothing_behind(
    scene: Scene, rollout: Rollout, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "egl")
    monkeypatch.setenv("PYOPENGL_PLATFORM", "none")
    with pytest.raises(RenderingError, match=PACKAGES):
        render_video(scene, rollout, (), tmp_path / "film.mp4", size=SIZE)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("wanted", ["egl", "off"])
def test_a_machine_without_gl_is_told_what_mends_it_in_one_sentence(
    wanted: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", wanted)
    monkeypatch.setenv("PYOPENGL_PLATFORM", "none")
    with pytest.raises(RenderingError, match=PACKAGES) as caught:
        check_rendering()
    assert "\n" not in str(caught.value) and CURE in str(caught.value) and "unset MUJOCO_GL" in str(caught.value)


def test_physics_needs_no_gl() -> None:
    done = run_without_gl(
        "import sim.world.scene, sim.rendering.video, mujoco; "
        "mujoco.MjData(mujoco.MjModel.from_xml_string('<mujoco/>'))"
    )
    assert done.returncode == 0, done.stderr


def test_a_frame_without_gl_is_a_rendering_error() -> None:
    code = """
import numpy as np
from prefplan.models.manipulation.model import Location, ManipulationModel
from sim.errors import RenderingError
from sim.world.scene import build_scene
from sim.rendering.video import render_frame
costs = dict(transit=1, grasp=1, transport=1, release=1)
scene = build_scene(ManipulationModel("home", costs, (Location("a", at=(0.5, 0.0)),), ()), meshes=False)
try:
    render_frame(scene, scene.mujoco.qpos0)
except RenderingError as error:
    print(error)
"""
    assert PACKAGES in run_without_gl(code).stdout


def test_a_backend_the_user_chose_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "osmesa")
    assert gl_environment()["MUJOCO_GL"] == "osmesa"
    monkeypatch.delenv("MUJOCO_GL")
    monkeypatch.setenv("DISPLAY", ":0")
    assert "MUJOCO_GL" not in gl_environment()
    monkeypatch.delenv("DISPLAY")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    if sys.platform == "linux":
        assert gl_environment()["MUJOCO_GL"] == "egl"
        assert "MUJOCO_GL" not in os.environ
