"""Robustness boundary of a plan: bisection over the amount of one perturbation."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

from rich.console import Console

from experiments.cli.console import table
from experiments.cli.files import make_folder
from experiments.cli.progress import Tell
from experiments.sweep.job import Sweep, define
from experiments.sweep.summary import failed_by_class, share, wilson
from experiments.sweep.workers import RECORDS, Record, work
from prefplan.scenario.decode import Scenario
from sim.world.randomization import KEYS

THRESHOLD = 0.95
"""Share of the rollouts that must be completed."""

HALVINGS = 6
"""Number of bisection steps: the boundary is found to a 64th of the key's greatest amount."""

DIGITS = 4
"""Decimals of an amount."""

BATCH = 10
"""Number of rollouts after which an amount may be abandoned."""

SWEEP_TOLD = ("scenario", "plan", "cost", "preference", "seed", "robot", "faults", "prefplan", "mujoco", "perturb")
"""Entries of a sweep's header that a result repeats."""

Interval = tuple[float | None, float | None]
"""The greatest amount at which the plan held, and the least at which it did not; None where there is none."""


def bisect(greatest: float, holds: Callable[[float], bool]) -> Interval:
    """Return the interval in which `holds` becomes false; if it holds at an amount, it is assumed to hold below."""
    if holds(greatest):
        return greatest, None
    low, high = 0.0, greatest
    for _ in range(HALVINGS):
        middle = round((low + high) / 2, DIGITS)
        low, high = (middle, high) if holds(middle) else (low, middle)
    if not low and not holds(0.0):
        return None, 0.0
    return low, high


def search_boundary(scenario: Scenario, job: Sweep, key: str, *, tell: Tell) -> dict[str, Any]:
    """Search, until Ctrl-C, for the least amount at which fewer than `THRESHOLD` of a sweep's rollouts are completed.

    A rollout is completed if its log confirms it. Every amount is a separate sweep with its own folder and the same
    seeds: finished rollouts are kept, and an interrupted search continues. An amount is abandoned, after each `BATCH`
    of rollouts, when the threshold can no longer be reached.

    Args:
        scenario: what is carried out.
        job: the sweep, whose perturbation gives all keys but `key`; the results go to its folder.
        key: of the perturbation to search, one of `KEYS`.
        tell: called with the progress.

    Returns:
        The result, if interrupted an incomplete one, as the documented JSON object.
    """
    trials: dict[float, list[Record]] = {}

    def show(stage: str, done: int, count: int, words: str) -> None:
        tell(stage, done, job.rollouts, words)

    def holds(amount: float) -> bool:
        name = f"{key}={amount:g}"
        perturbation = replace(job.perturbation, **{key: amount * KEYS[key].scale})
        trial = replace(job, perturbation=perturbation, folder=job.folder / name)
        make_folder(trial.folder)
        path, header = trial.folder / RECORDS, define(scenario, trial)
        for count in (*range(BATCH, job.rollouts, BATCH), job.rollouts):
            done = work(trial, count, path, header, tell=show, stage=name, jobs=job.jobs)
            trials[amount], interrupted = done
            if interrupted:
                raise KeyboardInterrupt
            if fails(trials[amount], job.rollouts):
                return False
        return True

    boundary: Interval | None = None
    with suppress(KeyboardInterrupt):
        boundary = bisect(KEYS[key].greatest, holds)
    header = define(scenario, job)
    return {
        **{name: header[name] for name in SWEEP_TOLD},
        "key": key,
        "unit": KEYS[key].unit,
        "greatest": KEYS[key].greatest,
        "threshold": THRESHOLD,
        "rollouts": job.rollouts,
        "complete": boundary is not None,
        "boundary": None if boundary is None else list(boundary),
        "trials": [_trial(amount, trials[amount], job.rollouts) for amount in sorted(trials)],
    }


def fails(records: Sequence[Record], rollouts: int) -> bool:
    """Return whether fewer than `THRESHOLD` of all rollouts are completed, whatever the outcome of the missing ones."""
    failed = sum(not record["completed"] for record in records)
    return failed > math.floor((1 - THRESHOLD) * rollouts + 1e-9)


def _trial(amount: float, records: Sequence[Record], rollouts: int) -> dict[str, Any]:
    completed, failed = sum(record["completed"] for record in records), fails(records, rollouts)
    return {
        "amount": amount,
        "completed": completed,
        "rollouts": len(records),
        "interval": wilson(completed, len(records)),
        "holds": not failed if len(records) == rollouts or (failed and len(records) >= BATCH) else None,
        "failures": [{"class": name, "count": len(those)} for name, those in failed_by_class(records).items()],
    }


def boundary_words(result: Mapping[str, Any]) -> str:
    """Return the interval of the boundary in words."""
    if not result["complete"]:
        return "not found yet"
    (low, high), unit, key = result["boundary"], result["unit"], result["key"]
    unit = "" if unit == "share" else f" {unit}"
    if high is None:
        return f"completion stays at {THRESHOLD:.0%} or above up to the greatest {key}, {low:g}{unit}"
    if low is None:
        return f"completion is below {THRESHOLD:.0%} without any {key}"
    return f"completion falls below {THRESHOLD:.0%} between {low:g} and {high:g}{unit}"


def show_boundary(console: Console, result: Mapping[str, Any]) -> None:
    """Print the amounts tried as a table, and the boundary."""
    title = f"{result['scenario']}, plan {result['plan']}: {result['key']}, and {result['perturb']}"
    rows = []
    for trial in result["trials"]:
        low, high = trial["interval"] or (0, 1)
        worst = trial["failures"][0] if trial["failures"] else None
        most = f"{worst['count']} x {worst['class']}" if worst else ""
        completed = share(trial["completed"], trial["rollouts"])
        rows.append((f"{trial['amount']:g}", completed, f"{low:.1%} to {high:.1%}", most))
    heads = (f"{result['key']}, {result['unit']}", "completed", "95 % interval (Wilson)", "most failures")
    console.print(table(title, heads, rows, right=[0]))
    console.print(f"\n{result['key']}: {boundary_words(result)}")
