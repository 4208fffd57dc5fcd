"""Random scenes: what `prefplan check` says to each, and what becomes of its cheapest plan.

A scene that the check refuses is carried out as well, without the test that refused it. Finished scenes are kept: after
an interruption, the same command continues. Run it as `python -m experiments.random_scenes`; it prints a page for
`experiments/results/random_scenes.md`, and leaves every scene as a file for `prefplan run`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from joblib import cpu_count

from experiments.cli.arguments import add_quiet, positive, seconds
from experiments.cli.files import make_folder
from experiments.cli.journal import Journal
from experiments.cli.options import add_options
from experiments.cli.progress import Bars
from experiments.cli.status import DONE, INTERRUPTED
from experiments.random_scenes.page import markdown
from experiments.random_scenes.processes import in_processes
from experiments.random_scenes.trial import CRASHED, TIMED_OUT, UNKNOWN, try_scene
from experiments.sweep.recorded import RECORDS


def main(arguments: Sequence[str] | None = None) -> int:
    """Try the scenes without a record, print the page and return the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.random_scenes",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--scenes", type=positive, default=300, metavar="N", help="how many (default: 300)")
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="seed of the scenes (default: 0)")
    parser.add_argument("--out", type=Path, default=Path("out/random_scenes"), help="records (default: %(default)s)")
    parser.add_argument(
        "--max-seconds", type=seconds, default=600.0, metavar="S", help="time limit of a scene (default: 600)"
    )
    add_options(parser, "--jobs")
    add_quiet(parser)
    options = parser.parse_args(arguments)
    make_folder(options.out)
    versions = {name: version(name) for name in ("prefplan", "mujoco")}
    header = {**versions, "seed": options.seed, "max_seconds": options.max_seconds}
    with Journal(options.out / RECORDS, header, key="scene") as records, Bars(quiet=options.quiet) as bars:
        asked = range(options.scenes)
        missing = [number for number in asked if number not in records.done]
        done = in_processes(
            try_scene,
            (options.seed, options.out),
            missing,
            jobs=options.jobs or cpu_count(),
            max_seconds=options.max_seconds,
            timed_out={"outcome": TIMED_OUT},
            crashed={"outcome": CRASHED},
        )
        interrupted = False
        try:
            for count, (number, record) in enumerate(done, options.scenes - len(missing) + 1):
                records.add({"scene": number, **UNKNOWN, **record})
                bars("scenes", count, options.scenes, "")
        except KeyboardInterrupt:
            interrupted = True
    found = [records.done[number] for number in asked if number in records.done]
    print(markdown(found, scenes=options.scenes, seed=options.seed, about=f"MuJoCo {versions['mujoco']}"))
    if interrupted:
        print("interrupted; the same command continues", file=sys.stderr)
    return INTERRUPTED if interrupted else DONE


if __name__ == "__main__":
    sys.exit(main())
