"""Logs of plans that were carried out, forgeries of them, and what a certificate refutes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from prefplan import ManipulationModel, Scenario, cheapest_plan
from prefplan.claims import Claims
from prefplan.replanning import continue_cheaply
from sim.evidence.certificate import certify
from sim.evidence.log import ARRAYS, Log, log_of
from sim.execution.closed_loop import ClosedLoop
from sim.execution.executor import Execution
from sim.execution.faults.fault import Fault, spares_for
from sim.simulation.run import Run
from sim.world.randomization import perturbed, read_perturbation
from sim.world.scene import build_scene, initial_state


def log_of_run(scenario: Scenario, **conditions: Any) -> Log:
    """Return the log of the cheapest plan, carried out to its end; see `run_and_log`."""
    return run_and_log(scenario, **conditions)[1]


def run_and_log(
    scenario: Scenario, *, seed: int | None = None, faults: Sequence[Fault] = (), perturbation: str = ""
) -> tuple[Run, Log]:
    """Carry the cheapest plan out to its end."""
    assert isinstance(scenario.model, ManipulationModel)
    problem = scenario.problem()
    scene = build_scene(scenario.model, spares=spares_for(faults))
    if perturbation:
        assert seed is not None
        scene = perturbed(scene, read_perturbation(perturbation), seed=seed)
    start = initial_state(scene, seed=seed)
    run = Execution(scene, start, system=problem.system, faults=faults, seed=seed)
    loop = ClosedLoop(run, problem, cheapest_plan(problem), go_on=continue_cheaply)
    loop.run()
    plan = loop.plan
    claims = Claims(
        completed=True,
        cost=plan.cost,
        task_costs=dict(plan.task_costs),
        violation_costs=dict(plan.violation_costs),
        preference=plan.preference,
        relaxations=plan.relaxations,
    )
    setting = {"seed": seed, "faults": [str(fault) for fault in faults], "perturbation": perturbation or None}
    done = run.record()
    return done, log_of(scene, done, claims, scenario=scenario.name, text=scenario.text, setting=setting)


def claiming(log: Log, **claims: Any) -> Log:
    return replace(log, about=replace(log.about, claims=replace(log.about.claims, **claims)))


def telling(log: Log, **about: Any) -> Log:
    return replace(log, about=replace(log.about, **about))


def refutations(log: Log) -> dict[str, str]:
    """Return the words of each refuted check, by its name."""
    return {check.name: check.words for check in certify(log).refuted}


def moved(log: Log, obj: str, position: tuple[float, ...], *, since: float, until: float = np.inf) -> Log:
    """Return a log in which an object lies elsewhere for a while."""
    qpos = log.qpos.copy()
    first = log.about.joints[obj]
    frames = (log.times >= since) & (log.times < until)
    qpos[frames, first : first + 7] = [*position, 1, 0, 0, 0]
    return replace(log, qpos=qpos)


def cut(log: Log, time: float) -> Log:
    """Return a log that ends at a time."""
    keep = log.times <= time
    arrays = {name: getattr(log, name)[keep] for name in ARRAYS}
    return replace(log, **arrays)


def without_action(log: Log, k: int) -> Log:
    """Return a log whose list of actions lacks action k, counted from 1."""
    actions = log.about.actions
    return telling(log, actions=actions[: k - 1] + actions[k:])
