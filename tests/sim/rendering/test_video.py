"""Videos of executions, and their captions."""

from __future__ import annotations

import os
import signal
from dataclasses import replace
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from joblib import delayed

from prefplan import ManipulationModel
from sim.errors import RenderingError
from sim.rendering import video
from sim.rendering.overlay import Caption, TaskStatus, caption_at, strip_height, with_strip
from sim.rendering.quality import DRAFT
from sim.rendering.video import LAST_FRAME_S, render_video
from sim.simulation.run import FRAME_RATE_HZ, Run
from sim.world.scene import build_scene, initial_state

SIZE = (160, 90)
TASKS = (TaskStatus("phi1", "F blue_bin1", "open"), TaskStatus("phi2", "F pink_bin1", "satisfied"))
CAPTIONS = (Caption(0.0, "transit top", 3, 34, TASKS), Caption(1.0, "grasp pink", 4, 34, TASKS))


def captioned(caption: Caption | None, size: tuple[int, int] = (640, 360)) -> np.ndarray:
    picture = np.full((size[1] - strip_height(size[1]), size[0], 3), 128, dtype=np.uint8)
    return with_strip(picture, caption, size[1])


def test_a_caption_is_shown_until_the_next_one_starts() -> None:
    assert caption_at(CAPTIONS, -0.1) is None
    assert caption_at(CAPTIONS, 0.0) is caption_at(CAPTIONS, 0.999) is CAPTIONS[0]
    assert caption_at(CAPTIONS, 1.0) is caption_at(CAPTIONS, 99.0) is CAPTIONS[1]
    assert caption_at((), 1.0) is None


def test_a_caption_stands_below_the_picture() -> None:
    for size in ((1280, 720), (640, 360), (160, 90)):
        frame, below = captioned(CAPTIONS[0], size), strip_height(size[1])
        assert frame.shape == (*size[::-1], 3) and below % 2 == 0 and below < 0.2 * size[1]
        assert (frame[:-below] == 128).all()
        assert frame[-below:].mean() < 64 and frame[-below:].max() > 180
        assert captioned(None, size)[-below:].max() < 64


def test_states_of_tasks_and_spent_cost_can_be_told_apart() -> None:
    done = tuple(replace(task, state="satisfied") for task in TASKS)
    changed = captioned(CAPTIONS[0]) != captioned(replace(CAPTIONS[0], cost=30, tasks=done))
    columns = changed.any(axis=(0, 2))
    assert columns[:200].any() and columns[270:].any()


def test_the_preference_stands_below_the_cost() -> None:
    bare = Caption(0, "grasp pink", 3, 34, ())
    changed = captioned(bare) != captioned(replace(bare, preference=2, preference_total=7))
    columns = np.flatnonzero(changed.any(axis=(0, 2)))
    assert len(columns) and columns.min() >= 16 and columns.max() < 260


@pytest.mark.parametrize("count", [1, 3, 4, 6, 9])
def test_tasks_are_all_shown_and_end_at_the_margin(count: int) -> None:
    tasks = tuple(TaskStatus(f"phi{i}", "on plate " * 40, "open") for i in range(count))
    bare = Caption(0, "release blue bin1", 0, 0, ())
    none, whole = (captioned(replace(bare, tasks=shown), (1280, 720)) for shown in ((), tasks))
    assert (none[:, -24:] == whole[:, -24:]).all()
    for i, task in enumerate(tasks):
        changed = (*tasks[:i], replace(task, state="satisfied"), *tasks[i + 1 :])
        marked = captioned(replace(bare, tasks=changed), (1280, 720))
        rows = np.flatnonzero((marked != whole).any(axis=(1, 2)))
        assert 10 <= np.ptp(rows) <= 40 and rows.max() < 716


def test_six_tasks_can_be_read_to_their_ends() -> None:
    texts = (
        "soup first on stove, then on plate1",
        "fish first on stove, then on plate3",
        "blue first on san, then on bin1",
    )
    tasks = tuple(
        TaskStatus(name, text, "open") for name, text in zip(("ada", "ben", "cleo") * 2, texts * 2, strict=True)
    )
    whole = captioned(Caption(0, "grasp pink", 3, 34, tasks), (1280, 720))
    for i, task in enumerate(tasks):
        for other in (replace(task, text=f"{task.text[:-1]}x"), replace(task, state="satisfied")):
            shown = Caption(0, "grasp pink", 3, 34, (*tasks[:i], other, *tasks[i + 1 :]))
            rows = np.flatnonzero((whole != captioned(shown, (1280, 720))).any(axis=(1, 2)))
            assert np.ptp(rows) >= 8


@pytest.mark.slow
@pytest.mark.usefixtures("rendered_here")
def test_a_video_holds_every_frame(arch_model: ManipulationModel, tmp_path: Path) -> None:
    scene = build_scene(arch_model)
    frames = 2 * FRAME_RATE_HZ
    qpos = np.tile(initial_state(scene).qpos, (frames, 1))
    qpos[:, 0] = np.linspace(0, 0.8, frames)
    times = np.arange(frames) / FRAME_RATE_HZ
    lit = [place.name for place in scene.model.locations].index("san")
    rollout = Run(
        reason=None,
        steps=(),
        events=(),
        times=times,
        qpos=qpos,
        qvel=np.zeros((frames, scene.mujoco.nv)),
        glow=np.where(times > 0.5, lit, -1),
        loads=dict.fromkeys(scene.robot.load_limits, np.zeros((frames, 7))),
        pad_forces=np.zeros((frames, 2)),
        controls=np.zeros((0, scene.mujoco.nu), int),
        interventions=np.zeros((0, 1)),
        sim_seconds=float(times[-1]),
        wall_seconds=0.0,
        placement_error=0.0,
        robot=scene.robot,
    )
    told: list[tuple[int, ...]] = []
    path = tmp_path / "new" / "video.mp4"
    quality = replace(DRAFT, size=SIZE, shadow_pixels=64)
    render_video(scene, rollout, CAPTIONS, path, quality=quality, progress=lambda *done: told.append(done))
    count = round((times[-1] + LAST_FRAME_S) * 30) + 1
    assert told[0] == (0, count) and len(told) > 2 and told[-1] == (count, count)
    reader = imageio_ffmpeg.read_frames(str(path))
    meta = next(reader)
    assert meta["codec"] == "h264" and meta["fps"] == 30 and meta["source_size"] == SIZE
    pictures = [np.frombuffer(data, np.uint8).reshape(90, 160, 3).astype(int) for data in reader]
    assert len(pictures) == count
    assert abs(pictures[0] - pictures[45]).max() > 100
    assert abs(pictures[-1] - pictures[-10]).mean() < 2
    assert [entry.name for entry in path.parent.iterdir()] == ["video.mp4"]


def test_parts_are_rendered_by_other_processes_and_one_that_ends_is_told() -> None:
    def fail() -> None:
        raise ValueError("no driver")

    def crash() -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    assert os.getpid() not in set(video._in_processes([delayed(os.getpid)()] * 2, 2))
    for job, message in ((fail, "ValueError: no driver"), (crash, "TerminatedWorkerError: ")):
        with pytest.raises(RenderingError, match=f"rendering failed: {message}"):
            list(video._in_processes([delayed(job)()], 2))
