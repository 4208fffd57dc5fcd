"""`prefplan film`: finished videos side by side, faster or smaller."""

from __future__ import annotations

import argparse
from pathlib import Path

from experiments.cli.arguments import Commands, add_command, number, positive
from experiments.cli.files import check_new, make_folder
from experiments.cli.start import loading
from experiments.cli.status import DONE
from prefplan.errors import PrefplanError

FPS = {".mp4": 30, ".gif": 12, ".webp": 15}
"""Frames per second by the ending of the file."""

SPEED = {".mp4": 1.0, ".gif": 4.0, ".webp": 4.0}
"""Default of `--speed` by the ending of the file: an animated picture on a page should last only seconds."""

HEIGHT = {".mp4": 540, ".gif": 270, ".webp": 270}
"""Default of `--height` by the ending of the file, pixels."""


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    examples = (
        "prefplan film out/tidy/cost.mp4 out/tidy/preference.mp4 both.mp4",
        "prefplan film out/tidy/cost.mp4 short.webp --speed 6",
    )
    parser = add_command(commands, film, *examples)
    parser.add_argument(
        "videos", nargs="+", metavar="VIDEO", type=Path, help="a finished video, or several to put side by side"
    )
    parser.add_argument("file", metavar="FILE", type=Path, help="the video to write; it ends in .mp4, .gif or .webp")
    parser.add_argument("--speed", type=number, metavar="N", help="N times as fast (default: 1; GIF and WebP: 4)")
    parser.add_argument("--height", type=positive, metavar="PIXELS", help="default: 540; GIF and WebP: 270")
    parser.add_argument("--force", action="store_true", help="replace FILE if it exists; never one of the videos")


def film(options: argparse.Namespace) -> int:
    """Put finished videos side by side, or make a short GIF or WebP of them."""
    with loading():
        from sim.rendering.clips import compose
    ending = options.file.suffix.lower()
    path: Path = options.file.with_suffix(ending)
    if ending not in FPS:
        raise PrefplanError(f"{path}: videos are written to files that end in {', '.join(FPS)}, not {ending!r}")
    if path.resolve() in [video.resolve() for video in options.videos]:
        raise PrefplanError(f"{path}: is one of the videos to read; write to another file")
    check_new(path, force=options.force)
    speed = SPEED[ending] if options.speed is None else float(options.speed)
    if speed == 0:
        raise PrefplanError("--speed 0: the video would not move; 1 is real time")
    height = options.height or HEIGHT[ending]
    make_folder(path.parent)
    headings = [video.stem for video in options.videos] if len(options.videos) > 1 else []
    compose(
        options.videos,
        path,
        headings=headings,
        height=height + height % 2,
        fps=FPS[ending],
        speed=speed,
    )
    print(path)
    return DONE
