"""Rollouts of a sweep, recorded in a file as soon as each is finished, so that none is repeated."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import timedelta
from importlib.metadata import version
from typing import Any

from joblib import cpu_count

from experiments.cli.journal import Journal
from experiments.cli.progress import Tell
from experiments.sweep import workers
from experiments.sweep.job import RolloutRecord, Sweep
from prefplan.scenario.decode import Scenario

RECORDS = "rollouts.jsonl"
"""File of the records in the folder of a sweep."""


def define(scenario: Scenario, job: Sweep) -> dict[str, Any]:
    """Return everything that determines the records of a sweep; not the number of rollouts or the machines used."""
    return {
        "prefplan": version("prefplan"),
        "mujoco": version("mujoco"),
        "scenario": scenario.name,
        "scenario_sha256": fingerprint(scenario),
        "plan": job.which,
        "cost": job.plan.cost,
        "preference": job.plan.preference,
        "actions": list(job.plan.actions),
        "seed": job.seed,
        "perturb": str(job.perturbation),
        "robot": job.robot,
        "faults": job.faults,
    }


def fingerprint(scenario: Scenario) -> str:
    """Return the hash of a scenario's file."""
    return hashlib.sha256(scenario.path.read_bytes()).hexdigest()


def work(
    job: Sweep,
    records: Journal,
    *,
    tell: Tell,
    stage: str = "sweeping",
    enough: Callable[[], bool] = lambda: False,
) -> None:
    """Carry out every rollout without a record until `enough` returns True; report the progress as a stage."""
    wanted = range(job.rollouts)
    missing = [number for number in wanted if number not in records.done]
    done, good = len(wanted) - len(missing), sum(records.done[i]["completed"] for i in wanted if i in records.done)
    tell(stage, done, job.rollouts, "")
    if not missing or enough():
        return
    results: Iterator[RolloutRecord]
    if job.cluster:
        results = workers.on_cluster(job, missing, address=job.cluster)
    else:
        results = workers.on_this_machine(job, missing, jobs=job.jobs or cpu_count(), enough=enough)
    began = time.monotonic()
    with closing(results):
        for new, record in enumerate(results, start=1):
            records.add(record)
            good += record["completed"]
            left = timedelta(seconds=round((time.monotonic() - began) / new * (len(missing) - new)))
            tell(stage, done + new, job.rollouts, f"{good / (done + new):.1%} completed, {left} left")
            if job.cluster and enough():
                return
