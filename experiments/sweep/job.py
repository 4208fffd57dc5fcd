"""One rollout of a sweep: a pure function of the sweep and the rollout's number."""

import hashlib
import pickle
import re
import shlex
import time
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from experiments.cli.choice import Wanted
from experiments.runs.certificates import Proof
from experiments.runs.evidence import evidence
from experiments.runs.outcome import Outcome
from experiments.runs.run_plan import run_plan
from experiments.sweep.faults import MAX_FAULTS, random_faults
from experiments.sweep.workers import Record
from prefplan import ManipulationModel, Plan, Scenario
from sim import Fault, Perturbation, Scene, build_scene, certify
from sim.execution.faults.fault import spares_for
from sim.external.bundle import digests

UNCHECKED: Record = {"certified": None, "agrees": None, "refuted": [], "findings": [], "proved": False}
"""Entries of a record without a log."""


@dataclass(frozen=True)
class Sweep:
    """Rollouts of one plan, each with different random perturbations of the nominal scene.

    Attributes:
        packed: the scenario, from `pack`: bytes, which are hashable, so that a worker builds each scene only once.
        given: the scenario as named on the command line.
        wanted: the plan as the options name it.
        seed: the seeds of the rollouts are drawn from it.
        perturbation: greatest random changes of the scene.
        faults: kind of the random faults of each rollout (`experiments.sweep.faults.random_faults`), or None.
        folder: of the results; a replay of a rollout is written to a subfolder.
        robot: one of `sim.robots.catalogue.ROBOTS`; None for the scenario's.
    """

    packed: bytes
    given: str
    wanted: Wanted
    plan: Plan
    seed: int
    perturbation: Perturbation
    faults: str | None
    folder: Path
    robot: str | None = None

    key = "rollout"

    def record(self, number: int) -> Record:
        """Carry a rollout out and return its record, also if the program raises an error."""
        faults: tuple[Fault, ...] = ()
        try:
            scenario, model = _unpacked(self.packed)
            faults = self.rollout_faults(number, model)
            scene = _scene(self.packed, self.robot, spares_for(faults))
            began, cpu = time.perf_counter(), time.thread_time()
            outcome = run_plan(
                scenario,
                scene,
                self.plan,
                seed=self.rollout_seed(number),
                perturbation=self.perturbation,
                faults=faults,
                choice=self.wanted.continuation,
            )
            times = {"wall_seconds": time.perf_counter() - began, "cpu_seconds": time.thread_time() - cpu}
            found = judged(outcome)
        except Exception as error:  # one error must not end a thousand rollouts
            kind = type(error).__name__
            return self.crashed(number, f"{kind}: {error}", kind=f"error: {kind}", faults=faults)
        return self._heading(number, faults) | found | {name: round(seconds, 3) for name, seconds in times.items()}

    def crashed(self, number: int, reason: str, *, kind: str = "crashed", faults: tuple[Fault, ...] = ()) -> Record:
        """Return the record of a rollout whose process ended without a result, twice, or that raised an error."""
        failed = {"completed": False, "class": kind, "reason": reason, "wrongly_completed": False}
        return self._heading(number, faults) | failed | UNCHECKED

    def _heading(self, number: int, faults: tuple[Fault, ...]) -> Record:
        return {
            "rollout": number,
            "seed": self.rollout_seed(number),
            "faults": [str(fault) for fault in faults],
            "replay": self.replay(number, faults),
        }

    def rollout_seed(self, number: int) -> int:
        """Return the seed of a rollout, counted from 0; it does not depend on the number of rollouts."""
        return int(np.random.SeedSequence([self.seed, number]).generate_state(1)[0])

    def rollout_faults(self, number: int, model: ManipulationModel) -> tuple[Fault, ...]:
        """Return the random faults of a rollout."""
        if not self.faults:
            return ()
        return random_faults(model, len(self.plan.actions), seed=self.rollout_seed(number), kind=self.faults)

    def replay(self, number: int, faults: tuple[Fault, ...] = ()) -> str:
        """Return the command line that carries a rollout out again, with a video."""
        options = [
            ("--plan", self.wanted.plan),
            ("--max-cost", self.wanted.max_cost),
            ("--max-preference", self.wanted.max_preference),
            ("--robot", self.robot),
            ("--seed", self.rollout_seed(number)),
            ("--perturb", self.perturbation),
            *(("--fault", fault) for fault in faults),
            ("--out", self.folder / f"rollout_{number}"),
        ]
        words = (word for name, value in options if value is not None for word in (name, str(value)))
        return shlex.join(["prefplan", "run", self.given, *words])


def define(scenario: Scenario, job: Sweep) -> dict[str, Any]:
    """Return everything that determines the records of a sweep; not the number of rollouts or the machines used."""
    assert isinstance(scenario.model, ManipulationModel)
    return {
        "prefplan": version("prefplan"),
        "mujoco": version("mujoco"),
        "scenario": scenario.name,
        "scenario_sha256": hashlib.sha256(scenario.path.read_bytes()).hexdigest(),
        "files": digests(scenario.model),
        "plan": job.wanted.plan,
        "cost": job.plan.cost,
        "preference": job.plan.preference,
        "actions": list(job.plan.actions),
        "seed": job.seed,
        "perturb": str(job.perturbation),
        "robot": job.robot,
        "faults": job.faults,
    }


def pack(scenario: Scenario) -> bytes:
    """Return a scenario as bytes, without caches."""
    return pickle.dumps(replace(scenario))


def judged(outcome: Outcome) -> Record:
    """Return the entries of a record about a run and its certificate.

    `longest_action` is the action that took most simulated time.
    """
    log, run = evidence(outcome), outcome.run
    certificate = certify(log, scenario=outcome.scenario)
    outcome = replace(outcome, proof=Proof(Path(), log, certificate))
    longest = max(run.steps, key=lambda step: step.end - step.start, default=None)
    return {
        "completed": outcome.completed,
        "class": None if outcome.reason is None else failure_class(outcome.reason, outcome.scene.model),
        "reason": outcome.reason,
        "wrongly_completed": run.completed and not outcome.completed,
        "actions": len(run.steps),
        "cost": outcome.ledger.final.cost,
        "replans": run.replans,
        "retries": run.retries,
        "violated": list(run.violated),
        "happened": [str(fault) for fault, when in outcome.faults if when is not None],
        "sim_seconds": round(run.sim_seconds, 3),
        "longest_action": longest and longest.action,
        "longest_action_seconds": round(longest.end - longest.start, 3) if longest else 0.0,
        "placement_error_mm": round(run.placement_error * 1000, 3),
        "speed_share": round(float(run.load_shares["speeds"].max()), 4),
        "torque_share": round(float(run.load_shares["torques"].max()), 4),
        "contacts": sum(event.kind == "contact" for event in run.events),
        "certified": certificate.confirmed,
        "agrees": certificate.agrees,
        "proved": certificate.verdict == "proved",
        "refuted": [f"{check.name}: {check.words}" for check in certificate.refuted],
        "findings": [f"{check.name}: {check.words}" for check in certificate.findings],
    }


def failure_class(reason: str, model: ManipulationModel) -> str:
    """Return a reason without names and numbers, so that failures of the same class can be counted."""
    for kind, names in (("LOCATION", model.locations), ("OBJECT", model.objects)):
        words = "|".join(re.escape(entry.name) for entry in names)
        reason = re.sub(rf"\b(?:{words})\b", kind, reason)
    return re.sub(r"-?\d+(?:\.\d+)?", "N", reason)


@lru_cache(maxsize=1)
def _unpacked(packed: bytes) -> tuple[Scenario, ManipulationModel]:
    """Return the scenario, its transition system built, and its model; computed once per process."""
    scenario: Scenario = pickle.loads(packed)
    scenario.problem()
    assert isinstance(scenario.model, ManipulationModel)
    return scenario, scenario.model


@lru_cache(maxsize=MAX_FAULTS + 1)
def _scene(packed: bytes, robot: str | None, spares: int) -> Scene:
    """Return the scene with this many spare objects for faults, compiled once per process."""
    return build_scene(_unpacked(packed)[1], robot=robot, spares=spares)
