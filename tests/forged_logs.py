"""Logs of plans that were carried out, forgeries of them, and what a certificate says against those."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from experiments.runs.carry_out import carry_out, scene_of
from experiments.runs.evidence import evidence
from prefplan import Scenario, pareto_front
from sim.evidence.certificate import certify
from sim.evidence.log import ARRAYS, Log


def log_of_plan(scenario: Scenario, *, index: int = 0, seed: int | None = None) -> Log:
    scene = scene_of(scenario)
    plan = pareto_front(scenario.problem())[index]
    return evidence(scenario, scene, carry_out(scenario, scene, plan, seed=seed), setting={"seed": seed})


def claiming(log: Log, **claims: Any) -> Log:
    return replace(log, about=replace(log.about, claims=replace(log.about.claims, **claims)))


def telling(log: Log, **about: Any) -> Log:
    return replace(log, about=replace(log.about, **about))


def refutations(log: Log) -> dict[str, str]:
    """Return what is refuted: words by name."""
    return {check.name: check.words for check in certify(log).refuted}


def moved(log: Log, obj: str, position: tuple[float, ...], *, since: float, until: float = np.inf) -> Log:
    """Return a log in which an object lies elsewhere for a while."""
    qpos = log.qpos.copy()
    first = log.about.joints[obj]
    frames = (log.times >= since) & (log.times < until)
    qpos[frames, first : first + 7] = [*position, 1, 0, 0, 0]
    return replace(log, qpos=qpos)


def cut(log: Log, time: float) -> Log:
    """Return a log of which only the frames up to a time are left."""
    keep = log.times <= time
    arrays = {name: getattr(log, name)[keep] for name in ARRAYS}
    return replace(log, **arrays)


def without_action(log: Log, k: int) -> Log:
    """Return a log from whose account action k, counted from 1, was dropped."""
    actions = log.about.actions
    return telling(log, actions=actions[: k - 1] + actions[k:])
