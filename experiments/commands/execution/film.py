"""`prefplan film`: finished videos side by side, or as a short GIF or WebP."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from experiments.cli.command import command
from experiments.cli.files import check_new, make_folder
from experiments.cli.status import DONE, say
from experiments.cli.values import PATH
from prefplan.errors import PrefplanError

ENDINGS = {".mp4": (30, 1.0, 540), ".gif": (12, 4.0, 270), ".webp": (15, 4.0, 270)}
"""Frames per second, speed and height, pixels, by the ending of the file: pictures on a page last only seconds."""


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
@click.option("--force", is_flag=True, help="Replace FILE if it exists; never one of the videos.")
def film(videos: Sequence[Path], file: Path, force: bool) -> int:
    """Put finished videos side by side, or make a short GIF or WebP of them, small and four times as fast.

    Examples:
      prefplan film out/tidy/cost.mp4 out/tidy/preference.mp4 both.mp4
      prefplan film out/tidy/cost.mp4 short.webp
    """
    from sim.rendering.clips import compose

    path = file.with_suffix(file.suffix.lower())
    if path.suffix not in ENDINGS:
        raise PrefplanError(
            f"{path}: videos are written to files that end in {', '.join(ENDINGS)}, not {path.suffix!r}"
        )
    if path.resolve() in [video.resolve() for video in videos]:
        raise PrefplanError(f"{path}: is one of the videos to read; write to another file")
    check_new(path, force=force)
    make_folder(path.parent)
    fps, speed, height = ENDINGS[path.suffix]
    headings = [video.stem for video in videos] if len(videos) > 1 else []
    say(compose(videos, path, headings=headings, height=height, fps=fps, speed=speed))
    return DONE
