"""Honest logs under the certificate: `python -m experiments.benchmark.honest_logs --rollouts 10`."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace

import click
import numpy as np

from experiments.cli.command import call, command
from experiments.cli.status import tell
from experiments.cli.values import positive
from experiments.runs.evidence import evidence
from experiments.runs.run_plan import run_plan, scene_of
from experiments.sweep.faults import ANY, random_faults
from prefplan.errors import PrefplanError
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.planner import Planner
from prefplan.scenario.decode import load
from sim.evidence.certificate import certify
from sim.evidence.log import Log
from sim.world.randomization import read_perturbation

SCENES = ("case_study_3", "shelf", "tower", "clutter", "kitchen")

HARSH = "position=8,angle=10,friction=0.3,pads=0.2,table=0.2,mass=0.3,centre=3,latency=20,noise=1,bias=1"


@command
@click.option("--rollouts", type=positive, default="10", metavar="N", help="Rollouts of each scene (default: 10).")
@click.option("--scenes", multiple=True, default=SCENES, metavar="SCENE", help="Only this scene; may be repeated.")
def judge_logs(rollouts: int, scenes: Sequence[str]) -> int:
    """Check honest logs: each must be proved here, and consistent where another environment is named.

    Every scene is carried out with random starts, perturbations and faults. Each log is checked three times: as it is,
    with another version of MuJoCo named in it, and with another machine and noise of 1e-12 in its positions.

    A table of the verdicts is printed. The exit status is 1 if a log is refuted.
    """
    refuted = 0
    print("| scene | logs | with faults | completed | proved | consistent elsewhere | with noise | refuted |")
    print("| --- " * 8 + "|")
    for scene in scenes:
        found: Counter[str] = Counter()
        for log, completed, faults in _logs(scene, rollouts):
            verdicts = _verdicts(scene, log)
            found.update(logs=1, faults=faults, completed=completed, refuted="refuted" in verdicts)
            found.update({key: verdict == want for key, verdict, want in zip(KEYS, verdicts, WANTED, strict=True)})
        row = [int(found[key]) for key in ("logs", "faults", "completed", *KEYS, "refuted")]
        print("|", " | ".join(map(str, [scene, *row])), "|", flush=True)
        refuted += found["refuted"]
    return 1 if refuted else 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Carry the command out and return its exit status."""
    return call(judge_logs, "python -m experiments.benchmark.honest_logs", arguments)


KEYS, WANTED = ("proved", "elsewhere", "noise"), ("proved", "consistent", "consistent")


def _logs(name: str, rollouts: int) -> Iterator[tuple[Log, bool, bool]]:
    """Yield the log of each rollout, whether it was completed, and whether it had a fault."""
    scenario = load(name)
    assert isinstance(scenario.model, ManipulationModel)
    plan = Planner(scenario.problem()).cheapest()
    for seed in range(rollouts):
        faults = random_faults(scenario.model, len(plan.actions), seed=seed, kind=ANY) if seed % 2 else ()
        scene = scene_of(scenario, faults=faults)
        try:
            outcome = run_plan(
                scenario,
                scene,
                plan,
                seed=seed,
                perturbation=read_perturbation(HARSH if seed % 3 else "position=5,angle=5"),
                faults=faults,
            )
        except PrefplanError as error:
            tell(f"{name}, seed {seed}: {error}")
            continue
        yield evidence(outcome), outcome.run.completed, bool(faults)


def _verdicts(name: str, log: Log) -> tuple[str, str, str]:
    """Return the verdict of a log here, with another MuJoCo, and with another machine and noise."""
    rng = np.random.default_rng(0)
    noise = {key: getattr(log, key) + 1e-12 * rng.normal(size=getattr(log, key).shape) for key in ("qpos", "qvel")}
    scenario, found = load(name), []
    for one in (log, _elsewhere(log, "mujoco"), replace(_elsewhere(log, "machine"), **noise)):
        certificate = certify(one, scenario=scenario)
        found.append(certificate.verdict)
        for check in certificate.refuted:
            tell(f"{name}: {check.name}: {check.words}")
    return found[0], found[1], found[2]


def _elsewhere(log: Log, part: str) -> Log:
    return replace(log, about=replace(log.about, versions=log.about.versions | {part: "another"}))


if __name__ == "__main__":
    sys.exit(main())
