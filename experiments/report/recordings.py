"""Plans carried out for a report; the results of an earlier call in the same folder are reused."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any, Unpack

from experiments.cli.files import write_json
from experiments.cli.progress import Tell
from experiments.runs.carry_out import carry_out, scene_of
from experiments.runs.evidence import certified, prove
from experiments.runs.outcome import Outcome, outcome_json
from prefplan.models.manipulation.action_costs import MeasuredCosts
from prefplan.plan import Plan
from prefplan.scenario.decode import Scenario
from sim.errors import LogError, RenderingError
from sim.evidence.log import Log, read_log
from sim.rendering.opengl import check_rendering
from sim.rendering.quality import DRAFT, Look, Quality
from sim.world.scene import Scene


@dataclass(frozen=True)
class Recording:
    """A plan as it was carried out.

    Attributes:
        log: of the run.
        log_path: its file.
        outcome: the documented JSON of `prefplan run`.
        certificate: the documented JSON of `prefplan verify`.
        video: its file, or None.
        no_video: why there is none although one was requested.
    """

    log: Log
    log_path: Path
    outcome: dict[str, Any]
    certificate: dict[str, Any]
    video: Path | None
    no_video: str | None = None


Recorded = tuple[dict[int, Recording], tuple[str, ...], bool]
"""Recordings by the plans' numbers on the front, notices for the reader, and whether the user ended it early."""


def record_all(
    scenario: Scenario,
    plans: Mapping[int, Plan],
    folder: Path,
    *,
    seed: int | None = None,
    robot: str | None = None,
    video: bool = True,
    tell: Tell = lambda stage, done, total, what: None,
    **look: Unpack[Look],
) -> Recorded:
    """Carry plans out and render their videos, until the user interrupts.

    The plans are given by their numbers on the front. Results are written to an existing folder, as `plan_I` with
    various suffixes. The other arguments are those of `carry_out`.

    Returns:
        See `Recorded`.

    Raises:
        ScenarioError: the arm cannot work in the scene.
        PrefplanError: a file cannot be written.
    """
    notices: tuple[str, ...] = ()
    if video:
        try:
            check_rendering()
        except RenderingError as error:
            video, notices = False, (f"no videos: {error}",)
    scene = scene_of(scenario, robot=robot)
    found, interrupted = dict[int, Recording](), False
    try:
        for i, plan in plans.items():

            def told(stage: str, done: int, total: int, what: str, name: str = f"plan {i}") -> None:
                tell(f"{name} {stage}", done, total, what)

            found[i] = _record(scenario, scene, plan, folder / f"plan_{i}", seed=seed, video=video, tell=told, **look)
    except KeyboardInterrupt:
        interrupted = True
    missing = tuple(f"no video of plan {i}: {one.no_video}" for i, one in found.items() if one.no_video)
    return found, (*notices, *missing), interrupted


def _record(
    scenario: Scenario,
    scene: Scene,
    plan: Plan,
    path: Path,
    *,
    seed: int | None,
    video: bool,
    tell: Tell,
    **look: Unpack[Look],
) -> Recording:
    """Carry a plan out, unless that was done before.

    Raises:
        KeyboardInterrupt: the user ended it.
    """
    found = read(path)
    if found is not None and found.outcome.get("made_from") == _fingerprint(scenario, scene, plan, seed):
        if (not video or found.outcome.get("rendered") == _rendered(**look)) and _is_still_so(scenario, found):
            return read(path) or found
    # An incomplete result must not look complete: the record is removed first and written last.
    path.with_suffix(".json").unlink(missing_ok=True)
    file = path.with_suffix(".mp4") if video else None
    # The page itself shows what captions would.
    outcome = carry_out(scenario, scene, plan, seed=seed, video=file, captioned=False, tell=tell, **look)
    if outcome.interrupted:
        raise KeyboardInterrupt
    tell("checking", 0, 0, "the log")
    found = keep(scenario, scene, plan, outcome, path, **look)
    tell("checking", 1, 1, "")
    return found


def keep(scenario: Scenario, scene: Scene, plan: Plan, outcome: Outcome, path: Path, **look: Unpack[Look]) -> Recording:
    """Write the log of an outcome, its certificate and, when these are complete, its record.

    Their paths are `path` with the suffixes `.npz`, `.certificate.json` and `.json`; that of a video must have `.mp4`.
    `plan` is the one before any replanning.

    Raises:
        PrefplanError: a file cannot be written.
    """
    outcome = prove(scenario, scene, outcome, path.with_suffix(".npz"))
    if outcome.video is None:
        path.with_suffix(".mp4").unlink(missing_ok=True)
    rendered = {"rendered": _rendered(**look)} if outcome.video else {}
    made_from = {"made_from": _fingerprint(scenario, scene, plan, outcome.seed)}
    write_json(path.with_suffix(".json"), outcome_json(outcome) | made_from | rendered)
    recording = read(path)
    assert recording is not None
    return replace(recording, no_video=outcome.no_video)


def _is_still_so(scenario: Scenario, found: Recording) -> bool:
    """Check the log of an earlier call now, since another may have taken its place; return whether it holds."""
    try:
        return certified(scenario, found.log_path).confirmed
    except LogError:
        return False


def read(path: Path) -> Recording | None:
    """Return the recording at a path without a suffix, or None if a file is missing or broken."""
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


def _rendered(quality: Quality = DRAFT, camera: str = "fixed") -> dict[str, Any]:
    """Return the settings of a video, JSON-ready."""
    return asdict(quality) | {"size": list(quality.size), "camera": camera}


def _fingerprint(scenario: Scenario, scene: Scene, plan: Plan, seed: int | None) -> str:
    """Return a digest of everything that a run depends on."""
    costs = getattr(scenario.model, "costs", None)
    measured = sorted(map(str, costs.entries.items())) if isinstance(costs, MeasuredCosts) else []
    everything = [version("prefplan"), scenario.text, measured, list(plan.actions), seed, scene.robot.name]
    return hashlib.sha256(json.dumps(everything).encode()).hexdigest()
