"""An execution as a film: saved states rendered by several processes, joined without another encoding."""

from __future__ import annotations

import os
import pickle
import queue
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import imageio_ffmpeg
import mediapy
import numpy as np

from sim.errors import RenderingError
from sim.rendering.cameras import Camera
from sim.rendering.overlay import Caption, caption_at, draw_caption
from sim.rendering.quality import DRAFT, Quality
from sim.rendering.renderer import CURE, Painter, gl_environment
from sim.simulation.rollout import FRAME_RATE, Rollout
from sim.world.scene import Scene

LAST_FRAME = 1.5
"""How long the last state stays on the screen, s."""

LAMP_TIME_CONSTANT = 0.15
"""Time constant with which a lamp comes on and goes off, s."""

FEWEST_FRAMES = 60
"""A process that renders fewer is not worth its second of starting up."""


@dataclass(frozen=True)
class _Chunk:
    """What one process renders.

    Attributes:
        times: (F,) simulated time of every frame, s.
        shares: (F,) how much of the film has passed, 0 .. 1.
        qpos: (F, nq) states.
        glow: for every marking location, (F,) how brightly its lamp glows.
    """

    scene: Scene
    times: np.ndarray
    shares: np.ndarray
    qpos: np.ndarray
    glow: dict[str, np.ndarray]
    captions: tuple[Caption, ...]
    size: tuple[int, int]
    quality: Quality
    camera: Camera
    fps: int
    path: Path


def render_video(
    scene: Scene,
    rollout: Rollout,
    captions: Sequence[Caption],
    path: Path | str,
    *,
    fps: int = 30,
    size: tuple[int, int] | None = None,
    quality: Quality = DRAFT,
    camera: Camera = "fixed",
    processes: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Render an execution as an H.264 MP4 file.

    Args:
        scene: the scene that was played in.
        rollout: what happened in it.
        captions: in order of `start`; none for a bare picture.
        path: the file to write; it appears only when it is complete.
        fps: pictures a second.
        size: (width, height) in pixels, both even; None for the quality's.
        quality: how much work a picture is worth.
        camera: where the film is seen from.
        processes: how many render at a time; None for one a core.
        progress: called with the number of frames done and of all frames, now and then.

    Returns:
        The path.

    Raises:
        RenderingError: no OpenGL, or a process failed.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    times, qpos, glow = _frames(scene, rollout, fps)
    shares = np.linspace(0, 1, len(times))
    size = size or quality.size
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    workers = max(1, min(processes or cores, len(times) // FEWEST_FRAMES))
    with tempfile.TemporaryDirectory(prefix=".video-", dir=path.parent) as folder:
        parts = []
        for i, rows in enumerate(np.array_split(np.arange(len(times)), workers)):
            part = Path(folder, f"{i}.mp4")
            lit = {name: level[rows] for name, level in glow.items()}
            chunk = _Chunk(
                scene, times[rows], shares[rows], qpos[rows], lit, tuple(captions), size, quality, camera, fps, part
            )
            part.with_suffix(".pickle").write_bytes(pickle.dumps(chunk))
            parts.append(part)
        _render_all(parts, len(times), max(1, cores // workers), progress)
        whole = Path(folder, "whole.mp4")
        _join(parts, whole)
        os.replace(whole, path)
    return path


def render_frame(
    scene: Scene,
    qpos: np.ndarray,
    *,
    caption: Caption | None = None,
    glow: Sequence[str] = (),
    size: tuple[int, int] | None = None,
    quality: Quality = DRAFT,
    camera: Camera = "fixed",
) -> np.ndarray:
    """Return a picture of one state, (height, width, 3) uint8.

    Args:
        scene: the scene.
        qpos: (nq,) positions of its MuJoCo model.
        caption: what to write over it.
        glow: marking locations at work.
        size: (width, height) in pixels; None for the quality's.
        quality: how much work the picture is worth.
        camera: where it is seen from.

    Raises:
        RenderingError: no OpenGL.
    """
    with Painter(scene, size=size, quality=quality, camera=camera) as painter:
        frame = painter.frame(qpos, glow=dict.fromkeys(glow, 1.0))
    if caption:
        draw_caption(frame, caption)
    return frame


def render_chunk(job: Path) -> None:
    """Render one process's share; prints a line for every frame it has done."""
    chunk: _Chunk = pickle.loads(job.read_bytes())
    mediapy.set_ffmpeg(imageio_ffmpeg.get_ffmpeg_exe())
    width, height = chunk.size
    frame, shown = None, None
    encoding = f"-preset {chunk.quality.preset} -threads 1"
    with (
        Painter(chunk.scene, size=chunk.size, quality=chunk.quality, camera=chunk.camera) as painter,
        mediapy.VideoWriter(
            chunk.path, (height, width), fps=chunk.fps, crf=chunk.quality.rate, ffmpeg_args=encoding
        ) as film,
    ):
        for i, time in enumerate(chunk.times):
            share = float(chunk.shares[i]) if chunk.camera == "orbit" else 0.0
            state = (chunk.qpos[i].tobytes(), share, *(level[i] for level in chunk.glow.values()))
            if state != shown:
                lit = {name: level[i] for name, level in chunk.glow.items()}
                picture = painter.frame(chunk.qpos[i], glow=lit, share=share)
                shown = state
            frame = picture.copy()
            caption = caption_at(chunk.captions, time)
            if caption:
                draw_caption(frame, caption)
            film.add_image(frame)
            print(flush=True)


def _frames(scene: Scene, rollout: Rollout, fps: int) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Return time, state and glow of every frame: the nearest recorded state, and the last one held."""
    duration = rollout.times[-1] - rollout.times[0]
    times = rollout.times[0] + np.arange(round((duration + LAST_FRAME) * fps) + 1) / fps
    rows = np.searchsorted(rollout.times, times - 0.5 / FRAME_RATE).clip(max=len(rollout.times) - 1)
    glow = {}
    for i, place in enumerate(scene.model.locations):
        if place.marks:
            glow[place.name] = _eased(rollout.glow[rows] == i, fps)
    return times, rollout.qpos[rows], glow


def _eased(on: np.ndarray, fps: int) -> np.ndarray:
    """Return how brightly a lamp glows that is switched on and off, (F,) in 0 .. 1."""
    level, share = np.zeros(len(on)), 1 - np.exp(-1 / (fps * LAMP_TIME_CONSTANT))
    for i in range(1, len(on)):
        level[i] = level[i - 1] + share * (on[i] - level[i - 1])
    return np.where(level < 0.01, 0.0, level)


def _render_all(parts: Sequence[Path], frames: int, threads: int, progress: Callable[[int, int], None] | None) -> None:
    """Run a process for every part, and see to it that none outlives this call."""
    environment = gl_environment() | {"LP_NUM_THREADS": str(threads), "OMP_NUM_THREADS": "1"}
    # -P: not from the folder of the call, where something else may be named `sim`.
    command = "import sys, pathlib, sim.rendering.video; sim.rendering.video.render_chunk(pathlib.Path(sys.argv[1]))"
    running, lines, done = [], queue.SimpleQueue[bool](), 0
    try:
        for part in parts:
            errors = part.with_suffix(".txt").open("wb")
            running.append(
                subprocess.Popen(
                    [sys.executable, "-P", "-c", command, part.with_suffix(".pickle")],
                    env=environment,
                    stdout=subprocess.PIPE,
                    stderr=errors,
                )
            )
            errors.close()
            threading.Thread(target=_listen, args=(running[-1], lines), daemon=True).start()
        for _ in parts:
            while lines.get():
                done += 1
                if progress:
                    progress(done, frames)
        for process, part in zip(running, parts, strict=True):
            if process.wait():
                _explain(part.with_suffix(".txt").read_text(errors="replace"))
    finally:
        for process in running:
            if process.poll() is None:
                process.kill()
            process.wait()


def _listen(process: subprocess.Popen[bytes], lines: queue.SimpleQueue[bool]) -> None:
    """Pass on True for every line a process prints, and False when it ends."""
    assert process.stdout is not None
    for _ in process.stdout:
        lines.put(True)
    lines.put(False)


def _explain(errors: str) -> None:
    lines = errors.strip().splitlines()
    why = lines[-1] if lines else "no message"
    known = why.rpartition("RenderingError: ")[2]
    raise RenderingError(known if CURE in known else f"rendering failed: {why}")


def _join(parts: Sequence[Path], whole: Path) -> None:
    """Put the parts together as they are."""
    index = whole.with_suffix(".txt")
    index.write_text("".join(f"file '{part.name}'\n" for part in parts))
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-y", "-f", "concat", "-i", str(index)]
    command += ["-c", "copy", "-movflags", "+faststart", str(whole)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RenderingError(f"ffmpeg could not join the parts: {done.stderr.strip()}")
