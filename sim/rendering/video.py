"""Video of an execution: its recorded states are rendered in parallel parts, which are joined without re-encoding."""

import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import accumulate, pairwise
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np
from joblib import cpu_count, delayed

from sim.errors import RenderingError
from sim.processes import in_processes
from sim.rendering.clips import run_ffmpeg
from sim.rendering.framing import REST_S, with_strays
from sim.rendering.overlay import Caption, caption_at, strip_height, with_strip
from sim.rendering.quality import DRAFT, Quality
from sim.rendering.renderer import Painter
from sim.simulation.run import FRAME_RATE_HZ, Run
from sim.world.scene import Scene

LAST_FRAME_S = 0.5
"""Time for which the last state is held, s: enough to read the caption, and no more than the hand pauses before."""

OPENING_S = 2.0
"""Time in which the camera moves in, s; the hand needs the same time to come down from home."""

PART_FRAMES = 100
"""Approximate number of frames of a part: six seconds of work, a fortieth of it to set up the renderer."""


@dataclass(frozen=True)
class _Frame:
    """A state, (nq,), at a simulated time, s, and a share, 0 .. 1, of the video; `glow` is as for `Painter.frame`."""

    time: float
    share: float
    qpos: np.ndarray
    glow: tuple[str, ...]


def render_video(
    scene: Scene,
    run: Run,
    captions: Sequence[Caption],
    path: Path | str,
    *,
    quality: Quality = DRAFT,
    camera: str = "fixed",
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Render an execution as an H.264 MP4 file, with one process per core.

    Args:
        scene: in which it was carried out.
        run: the recorded execution.
        captions: shown below the picture, in order of `start`; without any, the picture fills the frame.
        path: the file to write; it appears only when it is complete.
        quality: size, rendering and encoding settings.
        camera: as for `Painter`.
        progress: called with the number of frames done and of all frames, at the start and after each part.

    Returns:
        The path.

    Raises:
        RenderingError: there is no OpenGL, or a process failed.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    frames = _frames(scene, run)
    scene = with_strays(scene, run.qpos[:: round(REST_S * FRAME_RATE_HZ)])
    opening = OPENING_S * FRAME_RATE_HZ / len(frames)
    render = partial(_render_part, scene, captions, quality=quality, camera=camera, opening=opening)
    # `in_processes` starts at least two.
    workers = max(2, min(cpu_count(), len(frames) // PART_FRAMES))
    count = workers * max(1, round(len(frames) / (workers * PART_FRAMES)))
    bounds = [len(frames) * i // count for i in range(count + 1)]
    with tempfile.TemporaryDirectory(prefix=f".video-{os.getpid()}-", dir=path.parent) as folder:
        parts = {Path(folder, f"{first}.mp4"): frames[first:end] for first, end in pairwise(bounds)}
        jobs = [delayed(render)(part, shown) for part, shown in parts.items()]
        for done in accumulate(_in_processes(jobs, workers), initial=0):
            if progress:
                progress(done, len(frames))
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
    quality: Quality = DRAFT,
    camera: str = "fixed",
) -> np.ndarray:
    """Return a picture of one state, (height, width, 3) uint8; settings are as for `render_video`.

    The caption is below the picture, within the size; `glow` are marking locations at work.

    Raises:
        RenderingError: there is no OpenGL.
    """
    above = _above_strip(quality) if caption else quality
    with Painter(scene, quality=above, camera=camera) as painter:
        picture = painter.frame(qpos, glow=glow)
    return with_strip(picture, caption, quality.size[1]) if caption else picture


def _above_strip(quality: Quality) -> Quality:
    """Return the settings of a picture that fills a frame but for the strip with the caption."""
    width, height = quality.size
    return replace(quality, size=(width, height - strip_height(height)))


def _frames(scene: Scene, run: Run) -> list[_Frame]:
    """Return every frame: the recorded states, the last of which is held."""
    held = round(LAST_FRAME_S * FRAME_RATE_HZ)
    times = np.append(run.times, run.times[-1] + np.arange(1, held + 1) / FRAME_RATE_HZ)
    rows = np.arange(len(times)).clip(max=len(run.times) - 1)
    names = [place.name for place in scene.model.locations]
    return [
        _Frame(time, share, run.qpos[row], (names[int(run.glow[row])],) if run.glow[row] >= 0 else ())
        for time, share, row in zip(times, np.linspace(0, 1, len(times)), rows, strict=True)
    ]


def _in_processes(jobs: Sequence[Any], workers: int) -> Iterator[int]:
    """Run joblib jobs in other processes, and yield their results as they finish; `RenderingError` if one fails."""
    try:
        yield from in_processes(jobs, jobs=workers)
    except RenderingError:
        raise
    except Exception as failure:
        reason = f"{type(failure).__name__}: {failure}".strip().splitlines()[0]
        raise RenderingError(f"rendering failed: {reason}") from failure


def _render_part(
    scene: Scene,
    captions: Sequence[Caption],
    path: Path,
    frames: Sequence[_Frame],
    *,
    quality: Quality,
    camera: str,
    opening: float,
) -> int:
    """Render consecutive frames into a video of their own, in this thread, and return their number."""
    os.environ["LP_NUM_THREADS"] = "0"
    import mediapy  # imported late: it loads matplotlib's pyplot, which takes 0.4 s

    mediapy.set_ffmpeg(imageio_ffmpeg.get_ffmpeg_exe())
    encoding = f"-preset {quality.preset} -threads 1"
    above, (width, height) = _above_strip(quality) if captions else quality, quality.size
    with (
        Painter(scene, quality=above, camera=camera, opening=opening) as painter,
        mediapy.VideoWriter(path, (height, width), fps=FRAME_RATE_HZ, crf=quality.rate, ffmpeg_args=encoding) as video,
    ):
        for frame in frames:
            bare = painter.frame(frame.qpos, glow=frame.glow, share=frame.share)
            video.add_image(with_strip(bare, caption_at(captions, frame.time), height) if captions else bare)
    return len(frames)


def _join(parts: Iterable[Path], whole: Path) -> None:
    index = whole.with_suffix(".txt")
    index.write_text("".join(f"file '{part.name}'\n" for part in parts))
    options = ["-f", "concat", "-i", str(index), "-c", "copy", "-movflags", "+faststart", str(whole)]
    run_ffmpeg(options, making=whole)
