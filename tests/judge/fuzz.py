"""Compare the planner with the judges on random problems of every kind of preference and style of numbers.

Run by hand: `PYTHONPATH=tests python -m judge.fuzz --problems 100000`. The same seed gives the same problems;
`--seed NUMBER --problems 1` repeats a single one.
"""

from __future__ import annotations

import argparse
import itertools
import math
import random
import sys
import time
import traceback
from collections import Counter
from collections.abc import Iterator, Sequence

from judge.enumerate import TooManyError
from judge.numbers import STYLES, restyled
from judge.planners import PLANNERS
from judge.problems import GraphProblem
from judge.random_problems import random_problem
from judge.verdict import verdict

KINDS = (
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

ALL_PLANNERS_EVERY = 10
"""Every tenth problem is given to all planners, the others to the default one."""

AGREES, DIFFERS, FAILS, TOO_LARGE = "agree", "differ", "fail", "too large for the judge"


def draw(number: int) -> tuple[str, GraphProblem]:
    """Return the random problem of a number, with the names of its kind and style."""
    rng = random.Random(f"fuzz {number}")
    kind, relaxed = rng.choice(KINDS)
    tasks, depth = rng.choice((None, None, 1, 4)), rng.choice((2, 3, 3, 4))
    style = rng.choice((*STYLES, "mixed"))
    problem = random_problem(number, kind=kind, tasks=tasks, relaxed=relaxed, depth=depth)
    return f"{kind}{' over violation' if relaxed else ''}, {style}", restyled(rng, problem, style)


def judged(numbers: Iterator[int]) -> Iterator[tuple[int, str, str, str]]:
    """Yield for each problem its number, its name, the outcome and what is wrong."""
    for number in numbers:
        name, problem = draw(number)
        try:
            wrong = verdict(problem, PLANNERS if number % ALL_PLANNERS_EVERY == 0 else PLANNERS[:1])
            yield number, name, DIFFERS if wrong else AGREES, wrong or ""
        except TooManyError:
            yield number, name, TOO_LARGE, ""
        except Exception:
            yield number, name, FAILS, traceback.format_exc()


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw and judge problems until all are done, the time is up or Ctrl-C is pressed; return the exit status."""
    parser = argparse.ArgumentParser(prog="judge.fuzz", description="Hold the planner against the judges of the tests.")
    parser.add_argument("--problems", type=int, default=sys.maxsize, metavar="N", help="stop after so many")
    parser.add_argument("--seconds", type=float, default=math.inf, metavar="S", help="stop after this time")
    parser.add_argument("--seed", type=int, metavar="N", help="number of the first problem (default: by chance)")
    options = parser.parse_args(arguments)
    seed = random.SystemRandom().randrange(10**9) if options.seed is None else options.seed
    print(f"seed {seed}", flush=True)
    began, outcomes, slowest = time.monotonic(), Counter[str](), (0.0, seed)
    try:
        last = began
        for number, name, outcome, wrong in judged(itertools.islice(itertools.count(seed), options.problems)):
            outcomes[outcome] += 1
            now = time.monotonic()
            slowest = max(slowest, (now - last, number))
            last = now
            if wrong:
                print(f"seed {number} ({name}): {wrong}", flush=True)
            if now - began > options.seconds:
                break
    except KeyboardInterrupt:
        pass
    counts = ", ".join(f"{outcomes[outcome]} {outcome}" for outcome in (AGREES, DIFFERS, FAILS, TOO_LARGE))
    print(f"{sum(outcomes.values())} problems: {counts}; the slowest, seed {slowest[1]}, took {slowest[0]:.1f} s")
    return 1 if outcomes[DIFFERS] or outcomes[FAILS] else 0


if __name__ == "__main__":
    sys.exit(main())
