"""Random scenes: what `prefplan check` says to each, and what becomes of its cheapest plan.

A scene that the check refuses is carried out as well, without the test that refused it. Finished scenes are kept: after
an interruption, the same command continues. Run it as `python -m experiments.random_scenes`; it prints a page for
`experiments/results/random_scenes.md`, and leaves every scene as a file for `prefplan run`.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

import click
from joblib import cpu_count

from experiments.cli import options
from experiments.cli.command import call, command, is_quiet
from experiments.cli.files import make_folder
from experiments.cli.journal import Journal
from experiments.cli.progress import Bars
from experiments.cli.status import DONE, INTERRUPTED
from experiments.cli.values import PATH, positive, seconds
from experiments.random_scenes.page import markdown
from experiments.random_scenes.processes import in_processes
from experiments.random_scenes.trial import CRASHED, TIMED_OUT, UNKNOWN, try_scene
from experiments.sweep.recorded import RECORDS


@command
@click.option("--scenes", type=positive, default="300", metavar="N", help="How many (default: 300).")
@click.option("--seed", type=int, default=0, metavar="S", help="Seed of the scenes (default: 0).")
@click.option("--out", type=PATH, default="out/random_scenes", help="Records (default: out/random_scenes).")
@click.option("--max-seconds", type=seconds, default="600", metavar="S", help="Time limit of a scene (default: 600).")
@options.jobs
def try_scenes(scenes: int, seed: int, out: Path, max_seconds: float, jobs: int | None) -> int:
    """Try random scenes, and print what `prefplan check` says to each and what becomes of its cheapest plan.

    Finished scenes are kept: after an interruption, the same command continues. What is printed is a page for
    `experiments/results/random_scenes.md`; every scene is left as a file for `prefplan run`.
    """
    make_folder(out)
    versions = {name: version(name) for name in ("prefplan", "mujoco")}
    header = {**versions, "seed": seed, "max_seconds": max_seconds}
    with Journal(out / RECORDS, header, key="scene") as records, Bars(quiet=is_quiet()) as bars:
        asked = range(scenes)
        missing = [number for number in asked if number not in records.done]
        done = in_processes(
            try_scene,
            (seed, out),
            missing,
            jobs=jobs or cpu_count(),
            max_seconds=max_seconds,
            timed_out={"outcome": TIMED_OUT},
            crashed={"outcome": CRASHED},
        )
        interrupted = False
        try:
            for count, (number, record) in enumerate(done, scenes - len(missing) + 1):
                records.add({"scene": number, **UNKNOWN, **record})
                bars("scenes", count, scenes, "")
        except KeyboardInterrupt:
            interrupted = True
    found = [records.done[number] for number in asked if number in records.done]
    print(markdown(found, scenes=scenes, seed=seed, about=f"MuJoCo {versions['mujoco']}"))
    if interrupted:
        print("interrupted; the same command continues", file=sys.stderr)
    return INTERRUPTED if interrupted else DONE


def main(arguments: Sequence[str] | None = None) -> int:
    """Carry the command out and return its exit status."""
    return call(try_scenes, "python -m experiments.random_scenes", arguments)


if __name__ == "__main__":
    sys.exit(main())
