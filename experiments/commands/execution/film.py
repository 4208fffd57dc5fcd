"""`prefplan film`: finished videos side by side, faster or smaller."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from pathlib import Path

import click

from experiments.cli.command import command
from experiments.cli.files import check_new, make_folder
from experiments.cli.start import loading
from experiments.cli.status import DONE, say
from experiments.cli.values import PATH, number, positive
from prefplan.errors import PrefplanError

FPS = {".mp4": 30, ".gif": 12, ".webp": 15}
"""Frames per second by the ending of the file."""

SPEED = {".mp4": 1.0, ".gif": 4.0, ".webp": 4.0}
"""Default of `--speed` by the ending of the file: an animated picture on a page should last only seconds."""

HEIGHT = {".mp4": 540, ".gif": 270, ".webp": 270}
"""Default of `--height` by the ending of the file, pixels."""


@command
@click.argument(
    "videos",
    nargs=-1,
    required=True,
    metavar="VIDEO...",
    type=PATH,
    help="A finished video, or several to put side by side.",
)
@click.argument("file", type=PATH, help="The video to write; it ends in .mp4, .gif or .webp.")
@click.option("--speed", type=number, metavar="N", help="N times as fast (default: 1; GIF and WebP: 4).")
@click.option("--height", type=positive, metavar="PIXELS", help="Default: 540; GIF and WebP: 270.")
@click.option("--force", is_flag=True, help="Replace FILE if it exists; never one of the videos.")
def film(videos: Sequence[Path], file: Path, speed: Decimal | None, height: int | None, force: bool) -> int:
    """Put finished videos side by side, or make a short GIF or WebP of them.

    Examples:
      prefplan film out/tidy/cost.mp4 out/tidy/preference.mp4 both.mp4
      prefplan film out/tidy/cost.mp4 short.webp --speed 6
    """
    with loading():
        from sim.rendering.clips import compose
    ending = file.suffix.lower()
    path = file.with_suffix(ending)
    if ending not in FPS:
        raise PrefplanError(f"{path}: videos are written to files that end in {', '.join(FPS)}, not {ending!r}")
    if path.resolve() in [video.resolve() for video in videos]:
        raise PrefplanError(f"{path}: is one of the videos to read; write to another file")
    check_new(path, force=force)
    times = SPEED[ending] if speed is None else float(speed)
    if times == 0:
        raise PrefplanError("--speed 0: the video would not move; 1 is real time")
    pixels = height or HEIGHT[ending]
    make_folder(path.parent)
    headings = [video.stem for video in videos] if len(videos) > 1 else []
    compose(
        videos,
        path,
        headings=headings,
        height=pixels + pixels % 2,
        fps=FPS[ending],
        speed=times,
    )
    say(path)
    return DONE
