"""Plans carried out for a report, each once: what an earlier call left in the folder is taken as it is."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from experiments.cli.files import write_json
from experiments.runs.carry_out import Tell, carry_out
from experiments.runs.evidence import prove
from experiments.runs.outcome import Outcome, outcome_json
from prefplan.front import Plan
from prefplan.models.manipulation.action_costs import MeasuredCosts
from prefplan.scenario.decode import Scenario
from sim.errors import LogError
from sim.evidence.log import Log, read_log
from sim.world.randomization import Perturbation
from sim.world.scene import Scene


@dataclass(frozen=True)
class Recording:
    """A plan as it was carried out.

    Attributes:
        log: the run's log, as it was read back.
        log_path: where it lies.
        outcome: the documented JSON of `prefplan run`.
        certificate: the documented JSON of `prefplan verify`.
        video: its film, or None.
        no_video: why there is none although one was wanted.
    """

    log: Log
    log_path: Path
    outcome: dict[str, Any]
    certificate: dict[str, Any]
    video: Path | None
    no_video: str | None = None


def record(
    scenario: Scenario,
    scene: Scene,
    plan: Plan,
    path: Path,
    *,
    seed: int | None = None,
    size: tuple[int, int] = (1280, 720),
    film: bool = True,
    tell: Tell = lambda stage, done, total, what: None,
) -> Recording | None:
    """Carry a plan out and film it, unless that has been done already; None if the user ended it.

    Args:
        scenario: read from a file.
        scene: of its model.
        plan: what to do.
        path: of the results, without an ending; `.npz`, `.mp4`, `.certificate.json` and, when all of them are
            complete, `.json` are added.
        seed: None for the nominal world.
        size: (width, height) of the film in pixels.
        film: whether to film it; a film that is there already is kept.
        tell: told of progress.

    Raises:
        PrefplanError: a file cannot be written.
    """
    found = _reuse(path, _fingerprint(scenario, plan, seed), size if film else None)
    if found is not None:
        return found
    # What is half done must not look whole: the record goes first and comes last.
    path.with_suffix(".json").unlink(missing_ok=True)
    video = path.with_suffix(".mp4") if film else None
    outcome = carry_out(scenario, scene, plan, seed=seed, video=video, size=size, tell=tell)
    return None if outcome.interrupted else keep(scenario, scene, plan, outcome, path, size=size)


def keep(
    scenario: Scenario, scene: Scene, plan: Plan, outcome: Outcome, path: Path, *, size: tuple[int, int] = (1280, 720)
) -> Recording:
    """Write down what came of a plan: its log, its certificate and, when these are complete, its record.

    Args:
        scenario: read from a file.
        scene: what was simulated.
        plan: what was begun with.
        outcome: what came of it; its film, if there is one, lies at `path` with the ending `.mp4`.
        path: of the results, without an ending.
        size: of the film.

    Raises:
        PrefplanError: a file cannot be written.
    """
    drawn = None if outcome.seed is None else str(Perturbation())
    setting = {"seed": outcome.seed, "perturbation": drawn}
    outcome = prove(scenario, scene, outcome, path.with_suffix(".npz"), setting=setting)
    if outcome.video is None:
        path.with_suffix(".mp4").unlink(missing_ok=True)
    filmed = {"size": list(size)} if outcome.video else {}
    made_from = {"made_from": _fingerprint(scenario, plan, outcome.seed)}
    write_json(path.with_suffix(".json"), outcome_json(outcome) | made_from | filmed)
    recording = read(path)
    assert recording is not None
    return replace(recording, no_video=outcome.no_video)


def read(path: Path) -> Recording | None:
    """Return what was recorded under a path without an ending, or None if anything is missing or broken."""
    try:
        outcome = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
        certificate = json.loads(path.with_suffix(".certificate.json").read_text(encoding="utf-8"))
        log = read_log(path.with_suffix(".npz"))
    except (OSError, ValueError, LogError):
        return None
    video = path.with_suffix(".mp4") if outcome.get("video") else None
    if video is not None and not video.exists():
        return None
    return Recording(log, path.with_suffix(".npz"), outcome, certificate, video)


def _reuse(path: Path, made_from: str, size: tuple[int, int] | None) -> Recording | None:
    found = read(path)
    if found is None or found.outcome.get("made_from") != made_from:
        return None
    if size is not None and found.outcome.get("size") != list(size):
        return None
    return found


def _fingerprint(scenario: Scenario, plan: Plan, seed: int | None) -> str:
    """Return a digest of all that a run depends on."""
    costs = getattr(scenario.model, "costs", None)
    measured = sorted(map(str, costs.entries.items())) if isinstance(costs, MeasuredCosts) else []
    everything = [version("prefplan"), scenario.text, measured, list(plan.actions), seed]
    return hashlib.sha256(json.dumps(everything).encode()).hexdigest()
