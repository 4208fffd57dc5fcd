"""Finished videos side by side."""

import os
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

import imageio_ffmpeg
from PIL import Image, ImageDraw, ImageFont

from sim.errors import RenderingError

GAP_PX = 4
"""Gap between two videos side by side."""

HEADING = 0.055
"""Height of a heading's letters, as a share of the video's height."""

ENCODER = "-c:v libx264 -crf 21 -preset veryfast -pix_fmt yuv420p -movflags +faststart"
"""ffmpeg's options for the file to write."""


def compose(
    videos: Sequence[Path], path: Path, *, headings: Sequence[str] = (), height: int = 540, fps: int = 30
) -> Path:
    """Write an MP4 file of videos side by side; those that end before the longest one hold their last frame.

    Args:
        videos: to show, two at least.
        path: the file to write; it appears only when it is complete.
        headings: text in a strip above each video; none for no strip.
        height: of the videos in pixels, even; a strip adds to it.
        fps: frames a second.

    Returns:
        The path.

    Raises:
        RenderingError: a video is missing or cannot be read, or ffmpeg failed.
    """
    command = [part for video in videos for part in ("-i", str(video))]
    strip = 2 * round(HEADING * height) if headings else 0
    steps, shown = [], [f"[video{i}]" for i in range(len(videos))]
    for i, name in enumerate(shown):
        gap = GAP_PX if i else 0
        steps.append(
            f"[{i}:v]fps={fps},scale=-2:{height}:flags=lanczos,pad=iw:ih+{strip}:0:{strip}:0x090b0f,"
            f"pad=iw+{gap}:ih:{gap}:0:white{name}"
        )
    with tempfile.TemporaryDirectory(prefix=f".clip-{os.getpid()}-", dir=path.parent) as folder:
        for i, text in enumerate(headings):
            heading = Path(folder, f"{i}.png")
            _heading(text, height).save(heading)
            command += ["-i", str(heading)]
            steps.append(f"{shown[i]}[{len(videos) + i}:v]overlay=x=(W-w)/2:y=({strip}-h)/2[named{i}]")
            shown[i] = f"[named{i}]"
        steps.append(f"{''.join(shown)}hstack=inputs={len(videos)},crop=trunc(iw/2)*2:ih")
        draft = Path(folder, path.name)
        run_ffmpeg([*command, "-filter_complex", ";".join(steps), *ENCODER.split(), str(draft)], making=path)
        os.replace(draft, path)
    return path


def run_ffmpeg(command: Sequence[str], *, making: Path) -> None:
    """Run ffmpeg with some options; raise `RenderingError`, which names what was to be made, if it fails."""
    done = subprocess.run(
        [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-y", *command], capture_output=True, text=True
    )
    if done.returncode:
        raise RenderingError(f"{making}: ffmpeg could not make it: {done.stderr.strip().splitlines()[-1]}")


def _heading(text: str, height: int) -> Image.Image:
    """Return an image of white text on a transparent background."""
    font = ImageFont.load_default(size=HEADING * height)
    label = Image.new("RGBA", (round(font.getlength(text)), round(HEADING * height * 1.7)), (0, 0, 0, 0))
    centre = (label.width / 2, label.height / 2)
    ImageDraw.Draw(label).text(centre, text, fill=(245, 246, 248), font=font, anchor="mm")
    return label
