"""Plans carried out for a report; the results of an earlier call in the same folder are reused."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, Unpack

from experiments.cli.files import write_json
from experiments.cli.progress import Tell
from experiments.runs.certificates import Proof, certificate_json
from experiments.runs.evidence import proof_of, prove
from experiments.runs.outcome import Outcome, outcome_json
from experiments.runs.run_plan import run_plan
from prefplan import Plan, Scenario
from prefplan.models.manipulation.action_costs import MeasuredCosts
from sim import DRAFT, LogError, Quality, RenderingError, Scene
from sim.rendering.opengl import check_rendering
from sim.rendering.quality import Look


@dataclass(frozen=True)
class Recording:
    """A plan as it was carried out; `outcome` is the documented JSON of `prefplan run`.

    `video` is its file; `no_video` says why there is none although one was requested.
    """

    proof: Proof
    outcome: dict[str, Any]
    video: Path | None
    no_video: str | None = None

    @property
    def certificate(self) -> dict[str, Any]:
        """The documented JSON of `prefplan verify`."""
        return certificate_json(self.proof)


Recorded = tuple[dict[int, Recording], tuple[str, ...], bool]
"""Recordings by the plans' numbers on the front, notices for the reader, and whether the user ended it early."""


def record_all(
    scenario: Scenario,
    scene: Scene,
    plans: Mapping[int, Plan],
    folder: Path,
    *,
    seed: int | None,
    video: bool,
    tell: Tell,
    **look: Unpack[Look],
) -> Recorded:
    """Carry out plans, given by their numbers on the front, and render their videos, until the user interrupts.

    Results are written to an existing folder, as `plan_I` with various suffixes. The other arguments are those of
    `run_plan`.

    Raises:
        PrefplanError: a file cannot be written.
    """
    notices: tuple[str, ...] = ()
    if video:
        try:
            check_rendering()
        except RenderingError as error:
            video, notices = False, (f"no videos: {error}",)
    found = dict[int, Recording]()

    def record(i: int, plan: Plan) -> Recording:
        """Carry out a plan unless an earlier call did; raise KeyboardInterrupt if the user ends the run."""
        path, name = folder / f"plan_{i}", f"plan {i}"
        earlier = _earlier(scenario, path, made_from(scenario, scene, plan, seed), _rendered(**look) if video else None)
        if earlier is not None:
            return earlier
        # An incomplete result must not look complete: the record is removed first and written last.
        path.with_suffix(".json").unlink(missing_ok=True)
        file = path.with_suffix(".mp4") if video else None

        def told(stage: str, done: int, total: int, what: str) -> None:
            tell(f"{name} {stage}", done, total, what)

        # Captions would repeat what the page shows.
        outcome = run_plan(scenario, scene, plan, seed=seed, choice=i, video=file, captioned=False, tell=told, **look)
        if outcome.interrupted:
            raise KeyboardInterrupt
        told("checking", 0, 0, "the log")
        recording = keep(plan, outcome, path, **look)
        if recording.proof.certificate is None:
            raise KeyboardInterrupt
        told("checking", 1, 1, "")
        return recording

    interrupted = False
    try:
        for i, plan in plans.items():
            found[i] = record(i, plan)
    except KeyboardInterrupt:
        interrupted = True
    missing = tuple(f"no video of plan {i}: {one.no_video}" for i, one in found.items() if one.no_video)
    return found, (*notices, *missing), interrupted


def keep(plan: Plan, outcome: Outcome, path: Path, **look: Unpack[Look]) -> Recording:
    """Write the log of an outcome, its certificate and, when these are complete, its record.

    Their paths are `path` with the suffixes `.npz`, `.certificate.json` and `.json`; a video must be at `path` with
    `.mp4`. `plan` is the first plan, before any replanning.

    Raises:
        PrefplanError: a file cannot be written.
    """
    outcome = prove(outcome, path.with_suffix(".npz"))
    if outcome.video is None:
        path.with_suffix(".mp4").unlink(missing_ok=True)
    rendered = {"rendered": _rendered(**look)} if outcome.video else {}
    made = {"made_from": made_from(outcome.scenario, outcome.scene, plan, outcome.seed)}
    told = outcome_json(outcome) | made | rendered
    write_json(path.with_suffix(".json"), told)
    assert outcome.proof is not None
    return Recording(outcome.proof, told, outcome.video, outcome.no_video)


def _earlier(scenario: Scenario, path: Path, made: str, rendered: dict[str, Any] | None) -> Recording | None:
    """Return the recording of an earlier call if it was made from the same inputs and its log is confirmed, else None.

    `path` has no suffix. The log is checked again, since the file may have been replaced. `rendered` has the settings
    of the video, if one is wanted.
    """
    try:
        outcome = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
        video = path.with_suffix(".mp4") if outcome.get("video") else None
        if outcome["made_from"] != made or (rendered and outcome.get("rendered") != rendered):
            return None
        if video and not video.exists():
            return None
        proof = proof_of(scenario, path.with_suffix(".npz"))
    except (OSError, ValueError, AttributeError, TypeError, KeyError, LogError):
        return None
    if proof.certificate is None:
        raise KeyboardInterrupt
    return Recording(proof, outcome, video) if proof.certificate.confirmed else None


def _rendered(quality: Quality = DRAFT, camera: str = "fixed") -> dict[str, Any]:
    """Return the settings of a video, JSON-ready."""
    return asdict(quality) | {"size": list(quality.size), "camera": camera}


def made_from(scenario: Scenario, scene: Scene, plan: Plan, seed: int | None) -> str:
    """Return a digest of everything that a run depends on."""
    costs = getattr(scenario.model, "costs", None)
    measured = sorted(map(str, costs.entries.items())) if isinstance(costs, MeasuredCosts) else []
    everything = [version("prefplan"), scenario.text, measured, list(plan.actions), seed, scene.robot.name]
    return hashlib.sha256(json.dumps(everything).encode()).hexdigest()
