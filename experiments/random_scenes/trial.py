"""One random scene: what `prefplan check` answers, and what becomes of its cheapest plan.

The plan of a scene that the check refuses is carried out as well, without the test that refused it: this tells how
often the check refuses what the arm can do.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

from experiments.cli.files import write_bytes
from experiments.random_scenes.answer import answer
from experiments.random_scenes.drawing import scene_text
from experiments.runs.carry_out import carry_out
from experiments.runs.evidence import evidence
from experiments.runs.outcome import Outcome
from experiments.sweep.job import RolloutRecord, failure_class, observed
from prefplan.errors import PrefplanError
from prefplan.limits import Limits
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.planner import Planner
from prefplan.scenario.decode import Scenario, load
from sim.evidence.certificate import certify
from sim.world.randomization import Perturbation
from sim.world.scene import Scene, build_scene

USUAL = Perturbation()
"""Greatest differences of the start poses."""

UNKNOWN: RolloutRecord = {"allowed": None, "refusals": [], "check_cpu_seconds": None}
"""Entries of the record of a scene whose check has not ended."""

MAX_BYTES = 1e9
"""Memory for a run: planning again without an action that a task needs would otherwise take minutes to find nothing."""

COMPLETED, FAILED, REFUTED, ERROR = "completed", "failed honestly", "refuted", "program error"
NOT_BUILT, TIMED_OUT, CRASHED = "cannot be built", "timed out", "crashed"
OUTCOMES = (COMPLETED, FAILED, REFUTED, ERROR, NOT_BUILT, TIMED_OUT, CRASHED)
"""What becomes of a scene. A run is refuted if a check of its log does not hold, or if it hit something, even if it
says so. A run that says itself that a limit was exceeded has failed honestly."""


def try_scene(seed: int, folder: Path, number: int, tell: Callable[[RolloutRecord], None]) -> RolloutRecord:
    """Draw a scene, check it and carry its cheapest plan out.

    Args:
        seed: of the scenes.
        folder: gets the scene's file.
        number: of the scene.
        tell: gets the check's answer once it is known.

    Returns:
        The entries of the record that `tell` has not got.
    """
    path = folder / f"scene_{number}.toml"
    write_bytes(path, scene_text(seed, number).encode())
    began = time.process_time()
    try:
        scenario = load(path)
        model = scenario.model
        assert isinstance(model, ManipulationModel)
        scene, faults = answer(scenario, model)
    except PrefplanError as error:
        return {"allowed": False, "refusals": [str(error)], "outcome": NOT_BUILT}
    classes = list(dict.fromkeys(failure_class(fault, model) for fault in faults))
    tell({"allowed": not faults, "refusals": classes, "check_cpu_seconds": round(time.process_time() - began, 1)})
    try:
        scene = scene or build_scene(model, judged=False)
    except PrefplanError as error:
        return {"outcome": NOT_BUILT, "reason": str(error)}
    try:
        return _carried_out(scenario, scene, seed)
    except PrefplanError as error:
        return {"outcome": FAILED, "reason": str(error)}
    except Exception as error:  # one error must not end the experiment
        return {"outcome": ERROR, "reason": f"{type(error).__name__}: {error}"}


def _carried_out(scenario: Scenario, scene: Scene, seed: int) -> RolloutRecord:
    """Carry the cheapest plan out and return the entries of the record about the run.

    Raises:
        PrefplanError: there is no plan, or the run cannot begin.
    """
    began = time.process_time()
    plan = Planner(scenario.problem()).cheapest()
    with Limits(bytes=MAX_BYTES):
        outcome = carry_out(scenario, scene, plan, seed=seed, perturbation=USUAL)
    certificate = certify(evidence(scenario, scene, outcome))
    outcome = replace(outcome, certificate=certificate)
    measures = observed(scene.model, outcome)
    if certificate.refuted or measures["contacts"]:
        result = REFUTED
    else:
        result = COMPLETED if outcome.completed else FAILED
    return measures | {
        "outcome": result,
        "refuted": [f"{check.name}: {check.words}" for check in certificate.refuted],
        "findings": [f"{check.name}: {check.words}" for check in certificate.findings],
        "penetration_mm": round(1000 * penetration(scene, outcome), 2),
        "run_cpu_seconds": round(time.process_time() - began, 1),
    }


def penetration(scene: Scene, outcome: Outcome) -> float:
    """Return the greatest depth, in any frame, by which an object reaches into another or into what is fixed, m."""
    model, data, deepest = scene.mujoco, mujoco.MjData(scene.mujoco), 0.0
    of_robot = scene.robot.bodies(model)[model.geom_bodyid]
    for qpos in outcome.run.qpos:
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        apart = data.contact.dist[~of_robot[data.contact.geom.reshape(-1, 2)].any(axis=1)]
        deepest = max(deepest, -float(np.min(apart, initial=0.0)))
    return deepest
