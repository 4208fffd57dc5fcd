"""Videos made from finished ones: side by side, faster, smaller, as MP4, GIF or WebP."""

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

ENCODERS = {
    ".mp4": "-c:v libx264 -crf 21 -preset veryfast -pix_fmt yuv420p -movflags +faststart -f mp4",
    ".gif": "-loop 0 -f gif",
    ".webp": "-c:v libwebp_anim -quality 70 -loop 0 -f webp",
}
"""ffmpeg's options for each suffix of the file to write."""


def compose(
    videos: Sequence[Path],
    path: Path,
    *,
    headings: Sequence[str] = (),
    height: int = 540,
    fps: int = 30,
    speed: float = 1.0,
) -> Path:
    """Write a video of others side by side; those that end before the longest one hold their last frame.

    Args:
        videos: to show; a single one is only scaled and sped up.
        path: the file to write, with a suffix in `ENCODERS`. It appears only when it is complete.
        headings: text in a strip above each video; none for no strip.
        height: of the videos in pixels, even; a strip adds to it.
        fps: frames a second.
        speed: factor of the playback speed.

    Returns:
        The path.

    Raises:
        RenderingError: a video is missing or cannot be read, or ffmpeg failed.
    """
    durations = [_duration(video) for video in videos]
    command = [part for video in videos for part in ("-i", str(video))]
    steps, shown = [], []
    strip = 2 * round(HEADING * height) if headings else 0
    for i, duration in enumerate(durations):
        rest = max(durations) - duration
        steps.append(
            f"[{i}:v]tpad=stop_mode=clone:stop_duration={rest:.3f},setpts=PTS/{speed:g},fps={fps},"
            f"scale=-2:{height}:flags=lanczos,pad=iw:ih+{strip}:0:{strip}:0x090b0f,"
            f"pad=iw+{GAP_PX if i else 0}:ih:{GAP_PX if i else 0}:0:white[video{i}]"
        )
        shown.append(f"[video{i}]")
    with tempfile.TemporaryDirectory(prefix=f".clip-{os.getpid()}-", dir=path.parent) as folder:
        for i, text in enumerate(headings):
            heading = Path(folder, f"{i}.png")
            _heading(text, height).save(heading)
            command += ["-i", str(heading)]
            steps.append(f"{shown[i]}[{len(videos) + i}:v]overlay=x=(W-w)/2:y=({strip}-h)/2[named{i}]")
            shown[i] = f"[named{i}]"
        joined = f"{''.join(shown)}hstack=inputs={len(videos)}" if len(videos) > 1 else f"{shown[0]}null"
        if path.suffix == ".gif":
            joined += ",split[a][b];[a]palettegen[p];[b][p]paletteuse=dither=bayer:bayer_scale=4"
        elif path.suffix == ".mp4":
            joined += ",crop=trunc(iw/2)*2:ih"
        draft = Path(folder, f"whole{path.suffix}")
        command += ["-filter_complex", ";".join([*steps, joined]), *ENCODERS[path.suffix].split(), str(draft)]
        run_ffmpeg(command, making=path)
        os.replace(draft, path)
    return path


def run_ffmpeg(command: Sequence[str], *, making: Path) -> None:
    """Run ffmpeg with some options; raise `RenderingError`, which names what was to be made, if it fails."""
    done = subprocess.run(
        [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-y", *command], capture_output=True, text=True
    )
    if done.returncode:
        raise RenderingError(f"{making}: ffmpeg could not make it: {done.stderr.strip().splitlines()[-1]}")


def _duration(video: Path) -> float:
    """Return the length of a video, s."""
    try:
        return float(imageio_ffmpeg.count_frames_and_secs(video)[1])
    except (OSError, RuntimeError):
        why = "cannot be read as a video" if os.path.exists(video) else "no such file"
        raise RenderingError(f"{video}: {why}") from None


def _heading(text: str, height: int) -> Image.Image:
    """Return an image of white text on a transparent background."""
    font = ImageFont.load_default(size=HEADING * height)
    label = Image.new("RGBA", (round(font.getlength(text)), round(HEADING * height * 1.7)), (0, 0, 0, 0))
    centre = (label.width / 2, label.height / 2)
    ImageDraw.Draw(label).text(centre, text, fill=(245, 246, 248), font=font, anchor="mm")
    return label
