"""Random scenes: `PYTHONPATH=tests python -m judge.random_scenes`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

import click

from experiments.cli import options
from experiments.cli.command import call, command
from experiments.cli.files import only_writer
from experiments.cli.progress import Bars
from experiments.cli.status import DONE, INTERRUPTED, tell
from experiments.cli.values import PATH, POSITIVE, seconds
from experiments.sweep.workers import RECORDS, work
from judge.random_scenes.page import markdown
from judge.random_scenes.trial import Scenes


@command
@click.option("--scenes", type=POSITIVE, default="300", metavar="N", help="How many (default: 300).")
@click.option("--seed", type=int, default=0, metavar="S", help="Seed of the scenes (default: 0).")
@click.option("--out", type=PATH, default="out/random_scenes", help="Records (default: out/random_scenes).")
@click.option("--max-seconds", type=seconds, default="600", metavar="S", help="Time limit of a scene (default: 600).")
@options.jobs
def try_scenes(scenes: int, seed: int, out: Path, max_seconds: float, jobs: int | None) -> int:
    """Try random scenes, and print what `prefplan check` says to each and what becomes of its cheapest plan.

    A scene that the check refuses is carried out as well, without the test that refused it. Finished scenes are kept:
    after an interruption, the same command continues. Every scene is left as a file for `prefplan run`.
    """
    versions = {name: version(name) for name in ("prefplan", "mujoco")}
    header = {**versions, "seed": seed, "max_seconds": max_seconds}
    batch = Scenes(seed, out, max_seconds)
    with Bars() as bars, only_writer(out):
        found, interrupted = work(batch, scenes, out / RECORDS, header, tell=bars, stage="scenes", jobs=jobs)
    print(markdown(found, scenes=scenes, seed=seed, about=f"MuJoCo {versions['mujoco']}"))
    if interrupted:
        tell("interrupted; the same command continues")
    return INTERRUPTED if interrupted else DONE


def main(arguments: Sequence[str] | None = None) -> int:
    """Carry the command out and return its exit status."""
    return call(try_scenes, "python -m judge.random_scenes", arguments)


if __name__ == "__main__":
    sys.exit(main())
