"""By how much the world may differ until a plan fails: bisection over the amount of one perturbation."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from experiments.cli.files import make_folder
from experiments.cli.journal import Journal
from experiments.cli.progress import Tell
from experiments.sweep.job import RolloutRecord, Sweep
from experiments.sweep.recorded import RECORDS, define, work
from experiments.sweep.summary import failed_by_class, share, wilson
from prefplan.scenario.decode import Scenario
from sim.world.randomization import KEYS

THRESHOLD = 0.95
"""Share of the rollouts that must be completed."""

HALVINGS = 6
"""The boundary is known to a 64th of the key's greatest amount."""

DIGITS = 4
"""Decimals of an amount."""

MIN_ROLLOUTS = 10
"""Rollouts of an amount that are carried out even if fewer decide: its share of completed ones is reported, too."""

SWEEP_TOLD = ("scenario", "plan", "cost", "preference", "seed", "robot", "faults", "prefplan", "mujoco", "perturb")
"""What a result says of the sweeps that it comes from."""

Interval = tuple[float | None, float | None]
"""The greatest amount tried at which a plan holds, and the least at which it does not; None where there is none."""


def bisect(greatest: float, holds: Callable[[float], bool]) -> Interval:
    """Return between which amounts something ceases to hold; it is taken to hold at every amount below one."""
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
    """Search, up to Ctrl-C, for the amount at which fewer than `THRESHOLD` of a sweep's rollouts are completed.

    A rollout is completed if its log confirms it. Every amount is a sweep of its own, with a folder and the same seeds:
    finished rollouts are not lost, and the search goes on where it ended. An amount is left, after `MIN_ROLLOUTS` at
    least, as soon as enough have failed that it is below whatever the others give.

    Args:
        scenario: what is carried out.
        job: the sweep without the perturbation that is searched; the results go to its folder.
        key: of that perturbation, one of `KEYS`.
        tell: shows progress.

    Returns:
        What is known as the documented JSON object.
    """
    trials: dict[float, list[RolloutRecord]] = {}

    def holds(amount: float) -> bool:
        name = f"{key}={amount:g}"
        perturbation = replace(job.perturbation, **{key: amount * KEYS[key].scale})
        trial = replace(job, perturbation=perturbation, folder=job.folder / name)
        make_folder(trial.folder)
        with Journal(trial.folder / RECORDS, define(scenario, trial), key="rollout") as records:

            def known() -> list[RolloutRecord]:
                return decisive(records.done, job.rollouts)

            try:
                work(trial, records, tell=tell, stage=name, enough=lambda: decided(known(), job.rollouts))
            finally:
                trials[amount] = known()
        return not fails(trials[amount], job.rollouts)

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


def decisive(done: Mapping[int, RolloutRecord], rollouts: int) -> list[RolloutRecord]:
    """Return the records up to the first gap, or until they are `decided`."""
    records: list[RolloutRecord] = []
    for number in range(rollouts):
        if number not in done or decided(records, rollouts):
            break
        records.append(done[number])
    return records


def decided(records: Sequence[RolloutRecord], rollouts: int) -> bool:
    """Return whether the threshold is out of reach after enough rollouts, or no rollouts are left."""
    return len(records) == rollouts or len(records) >= MIN_ROLLOUTS and fails(records, rollouts)


def fails(records: Sequence[RolloutRecord], rollouts: int) -> bool:
    """Return whether fewer than `THRESHOLD` of all rollouts are completed, whatever those without record give."""
    failed = sum(not record["completed"] for record in records)
    return failed > math.floor((1 - THRESHOLD) * rollouts + 1e-9)


def _trial(amount: float, records: Sequence[RolloutRecord], rollouts: int) -> dict[str, Any]:
    completed = sum(record["completed"] for record in records)
    return {
        "amount": amount,
        "completed": completed,
        "rollouts": len(records),
        "interval": wilson(completed, len(records)),
        "holds": not fails(records, rollouts) if decided(records, rollouts) else None,
        "failures": [{"class": name, "count": len(failed)} for name, failed in failed_by_class(records).items()],
    }


def boundary_words(result: Mapping[str, Any]) -> str:
    """Return between which amounts the boundary lies, in a sentence."""
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
    title = f"{escape(result['scenario'])}, plan {result['plan']}: {result['key']}, and {result['perturb']}"
    table = Table(title=title, title_justify="left")
    table.add_column(f"{result['key']}, {result['unit']}", justify="right")
    table.add_column("completed")
    table.add_column("95 % interval (Wilson)")
    table.add_column("most failures")
    for trial in result["trials"]:
        low, high = trial["interval"] or (0, 1)
        worst = trial["failures"][0] if trial["failures"] else None
        table.add_row(
            f"{trial['amount']:g}",
            share(trial["completed"], trial["rollouts"]),
            f"{low:.1%} to {high:.1%}",
            escape(f"{worst['count']} x {worst['class']}") if worst else "",
        )
    console.print(table)
    console.print(f"\n{result['key']}: {boundary_words(result)}")
