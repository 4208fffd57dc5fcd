"""The plans of a front, one after another, carried out and filmed for a report."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from experiments.report.recordings import Recording, record
from experiments.runs.carry_out import Tell, scene_of
from prefplan.front import Plan
from prefplan.scenario.decode import Scenario
from sim.errors import RenderingError
from sim.rendering.renderer import check_rendering


@dataclass(frozen=True)
class PlanRecorder:
    """What came of carrying plans out.

    Attributes:
        recordings: by the plans' numbers.
        notices: what the reader must know, each a sentence.
        interrupted: whether the user ended it early.
    """

    recordings: dict[int, Recording]
    notices: tuple[str, ...]
    interrupted: bool


def perform(
    scenario: Scenario,
    plans: Mapping[int, Plan],
    folder: Path,
    *,
    seed: int | None = None,
    size: tuple[int, int] = (1280, 720),
    film: bool = True,
    tell: Tell = lambda stage, done, total, what: None,
) -> PlanRecorder:
    """Carry plans out and film them, up to the first that the user interrupts.

    Args:
        scenario: a manipulation scenario, read from a file.
        plans: of its front, by number.
        folder: of the results, `plan_I` with several endings; it exists.
        seed: None for the nominal world.
        size: (width, height) of the films in pixels.
        film: whether to film them.
        tell: told of progress.

    Raises:
        ScenarioError: the scene is one that the arm cannot work in.
        PrefplanError: a file cannot be written.
    """
    notices: tuple[str, ...] = ()
    if film:
        try:
            check_rendering()
        except RenderingError as error:
            film, notices = False, (f"no videos: {error}",)
    scene = scene_of(scenario)
    recordings: dict[int, Recording] = {}
    try:
        for i, plan in plans.items():

            def told(stage: str, done: int, total: int, what: str, name: str = f"plan {i}") -> None:
                tell(f"{name} {stage}", done, total, what)

            recording = record(scenario, scene, plan, folder / f"plan_{i}", seed=seed, size=size, film=film, tell=told)
            if recording is None:
                return PlanRecorder(recordings, notices, interrupted=True)
            recordings[i] = recording
            if recording.no_video:
                notices += (f"no video of plan {i}: {recording.no_video}",)
    except KeyboardInterrupt:
        return PlanRecorder(recordings, notices, interrupted=True)
    return PlanRecorder(recordings, notices, interrupted=False)
