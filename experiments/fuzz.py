"""Hold the planner against the judges of the tests on random problems, for as long as one likes.

It needs a checkout with its tests and the `dev` extra. Problems on which they differ are saved as scenario files.
"""

from __future__ import annotations

import argparse
import importlib
import itertools
import math
import random
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from experiments.files import make_folder
from experiments.progress import Bars
from experiments.start import loading, tell_if_compiling
from prefplan.errors import PrefplanError

FINE, DIFFER, CANNOT = 0, 1, 2

TESTS = Path(__file__).resolve().parent.parent / "tests"
FOLDER = Path("out", "fuzz")
"""Where problems are saved."""

DRAWN = (
    ("order", False),
    ("weighted-sum", False),
    ("max", False),
    ("deadline", False),
    ("expression", False),
    ("sum", False),
    ("weighted-sum", True),
    ("max", True),
    ("sum", True),
)
"""Kinds of preference, and whether over violation costs of relaxed tasks."""

EVERY_WAY = 5
"""All ways to search are tried on every fifth problem, the usual one on the others."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw and judge problems until the time is over or Ctrl-C, and return the exit status."""
    options = _parser().parse_args(arguments)
    seed = random.SystemRandom().randrange(10**9) if options.seed is None else options.seed
    print(f"seed {seed}", flush=True)
    judged = failed = 0
    try:
        with loading():
            judge, verdict, toml = _tools()
        tell_if_compiling()
        deadline = time.monotonic() + options.seconds
        with Bars() as bars:
            for judged, number in enumerate(itertools.count(seed)):
                if time.monotonic() >= deadline:
                    break
                bars("judging", judged, 0, f"{judged} problems, {failed} differ")
                problem = draw(judge, number)
                wrong = _difference(verdict, problem, thorough=judged % EVERY_WAY == 0)
                if wrong is not None:
                    failed += 1
                    print(f"seed {number}: {_save(toml, problem, number, wrong)}: {wrong}", flush=True)
    except KeyboardInterrupt:
        pass
    except PrefplanError as error:
        print(f"fuzz: {error}", file=sys.stderr)
        return CANNOT
    print(f"{judged} problems judged, {failed} differ")
    return DIFFER if failed else FINE


def draw(judge: Any, number: int) -> Any:
    """Return the random problem of a number, as a `judge.GraphProblem`."""
    rng = random.Random(f"fuzz {number}")
    kind, relaxed = rng.choice(DRAWN)
    tasks, decimals, depth = rng.choice((None, None, 1, 4)), rng.choice((0, 0, 0, 1, 2)), rng.choice((2, 3, 3, 4))
    return judge.random_problem(number, kind=kind, tasks=tasks, relaxed=relaxed, decimals=decimals, depth=depth)


def _tools() -> tuple[Any, Any, Any]:
    """Return the judges' package, its module of verdicts, and the writer of TOML files.

    Raises:
        PrefplanError: they are not there.
    """
    if not (TESTS / "judge").is_dir():
        raise PrefplanError(f"{TESTS / 'judge'} is missing: fuzzing needs a checkout of prefplan with its tests")
    if str(TESTS) not in sys.path:
        sys.path.append(str(TESTS))
    try:
        toml = importlib.import_module("tomli_w")
    except ModuleNotFoundError:
        raise PrefplanError("tomli-w is missing: fuzzing needs the extra 'dev' (pip install -e '.[dev]')") from None
    return importlib.import_module("judge"), importlib.import_module("judge.verdict"), toml


def _difference(verdict: Any, problem: Any, *, thorough: bool) -> str | None:
    """Return how the planner and the judges differ on a problem, or None."""
    try:
        wrong: str | None = verdict.verdict(problem, verdict.WAYS if thorough else verdict.WAYS[:1])
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return wrong


def _save(toml: Any, problem: Any, number: int, wrong: str) -> Path:
    """Write a problem as a scenario file that says what is wrong, and return its path.

    Raises:
        PrefplanError: it cannot be written.
    """
    make_folder(FOLDER)
    path = FOLDER / f"problem_{number}.toml"
    remarks = "".join(f"# {line}\n" for line in wrong.splitlines())
    path.write_text(f"{remarks}\n{toml.dumps(problem.scenario())}", encoding="utf-8")
    return path


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="fuzz.py", description="Hold the planner against the judges of the tests.")
    parser.add_argument(
        "--seconds", type=_seconds, default=math.inf, metavar="S", help="stop after this time (default: at Ctrl-C)"
    )
    parser.add_argument("--seed", type=int, metavar="N", help="number of the first problem (default: by chance)")
    return parser


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not value >= 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number >= 0")
    return value


if __name__ == "__main__":
    sys.exit(main())
