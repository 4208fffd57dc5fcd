"""One random scene: what `prefplan check` answers, and what becomes of its cheapest plan.

The plan of a scene that the check refuses is carried out as well, made without asking the arm and without the test
that refused the scene: this tells how often the check refuses what the arm can do.
"""

from __future__ import annotations

import faulthandler
import os
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from types import FrameType
from unittest.mock import patch

from experiments.checks.checkup import check, impossible
from experiments.cli.files import write_bytes
from experiments.runs.geometry import asking_in
from experiments.runs.run_plan import run_plan
from experiments.sweep.job import failure_class, judged
from experiments.sweep.workers import Record
from judge.random_scenes.generator import scene_text
from prefplan.errors import PrefplanError
from prefplan.limits import Limits
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.planner import Planner
from prefplan.scenario.decode import Scenario, load
from sim.capability.answers import Capability
from sim.world.randomization import Perturbation
from sim.world.scene import Scene, build_scene

USUAL = Perturbation()
"""Greatest differences of the start poses."""

UNKNOWN: Record = {"allowed": None, "refusals": [], "check_cpu_seconds": None}
"""Entries of the record of a scene whose check has not ended."""

MAX_BYTES = 1e9
"""Memory for a run: planning again without an action that a task needs would otherwise take minutes to find nothing."""

GRACE_S = 60.0
"""Time in which a scene whose time is up has to end by itself."""

COMPLETED, FAILED, REFUTED, ERROR = "completed", "failed honestly", "refuted", "program error"
NOT_BUILT, TIMED_OUT, CRASHED = "cannot be built", "timed out", "crashed"
OUTCOMES = (COMPLETED, FAILED, REFUTED, ERROR, NOT_BUILT, TIMED_OUT, CRASHED)
"""What becomes of a scene. A run is refuted if a check of its log does not hold, or if it hit something, even if it
says so. A run that says itself that a limit was exceeded has failed honestly."""


class TimeUp(BaseException):
    """The time of a scene is up; no handler of errors stops it."""


@dataclass(frozen=True)
class Scenes:
    """The scenes of a seed, each tried in a process.

    Attributes:
        seed: of the scenes.
        folder: gets each scene's file.
        max_seconds: time limit of a scene, s.
    """

    seed: int
    folder: Path
    max_seconds: float

    key = "scene"

    def record(self, number: int) -> Record:
        """Draw a scene, check it and carry its cheapest plan out; return what is known when its time is up."""
        known = {"scene": number, **UNKNOWN, "outcome": NOT_BUILT}
        try:
            with _time_limit(self.max_seconds):
                try_scene(self.seed, self.folder, known)
        except TimeUp:
            known["outcome"] = TIMED_OUT
        except PrefplanError as error:
            told = {"reason": str(error)} if known["allowed"] is not None else {"refusals": [str(error)]}
            known |= {"allowed": bool(known["allowed"])} | told
        except Exception as error:  # one error must not end the experiment
            known |= {"outcome": ERROR, "reason": f"{type(error).__name__}: {error}"}
        return known

    def crashed(self, number: int, reason: str) -> Record:
        """Return the record of a scene whose process ended without a result, twice."""
        return {"scene": number, **UNKNOWN, "outcome": CRASHED, "reason": reason}


@contextmanager
def _time_limit(seconds: float) -> Iterator[None]:
    """Raise TimeUp after a time; end the process if it has not reached Python code `GRACE_S` later."""

    def end(number: int, frame: FrameType | None) -> None:
        raise TimeUp

    signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    faulthandler.dump_traceback_later(seconds + GRACE_S, exit=True)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        faulthandler.cancel_dump_traceback_later()


def try_scene(seed: int, folder: Path, known: Record) -> None:
    """Draw a scene, write it to a folder, check it and carry its cheapest plan out.

    What becomes known is added to its record; the outcome there is always what it is if an error follows.

    Raises:
        PrefplanError: the scene cannot be built, there is no plan, or the run cannot begin.
    """
    path = folder / f"scene_{known['scene']}.toml"
    write_bytes(path, scene_text(seed, known["scene"]).encode())
    began = time.process_time()
    scenario = load(path)
    model = scenario.model
    assert isinstance(model, ManipulationModel)
    scene, faults = answer(scenario, model)
    classes = list(dict.fromkeys(failure_class(fault, model) for fault in faults))
    known |= {"allowed": not faults, "refusals": classes, "check_cpu_seconds": round(time.process_time() - began, 1)}
    if scene is not None and not faults:
        scenario = asking_in(scenario, scene)
    with unjudged():
        scene = scene or build_scene(model)
        known["outcome"] = FAILED
        known |= _carried_out(scenario, scene, seed)


@contextmanager
def unjudged() -> Iterator[None]:
    """Let layouts be built in which the robot cannot work, as far as they have a slot for everything."""
    with (
        patch("sim.world.layout.collisions", lambda stations: ()),
        patch("sim.world.layout.check_surroundings", lambda station, model: None),
    ):
        yield


@patch.dict(os.environ, XDG_CACHE_HOME=os.devnull)  # no answer is kept
def answer(scenario: Scenario, model: ManipulationModel) -> tuple[Scene | None, list[str]]:
    """Return a scenario's scene, None if the check refuses its layout, and why `prefplan check` refuses it, if it does.

    A plan that needs only what the arm can do says that it does not, without trying out every object everywhere.

    Raises:
        PrefplanError: the scenario has a mistake.
    """
    scene = None
    with suppress(PrefplanError):
        scene = build_scene(model)
        capability = Capability(model, scene=scene)
        if capability.check_start() is None:
            able = replace(scenario, feasible=capability)
            Planner(able.problem()).cheapest()
            return scene, []
    found = check(scenario)
    return scene, found["faults"] or [f"task {name} cannot be satisfied" for name in impossible(found)]


def _carried_out(scenario: Scenario, scene: Scene, seed: int) -> Record:
    """Carry the cheapest plan out and return the entries of the record about the run."""
    began = time.process_time()
    plan = Planner(scenario.problem()).cheapest()
    with Limits(bytes=MAX_BYTES):
        outcome = run_plan(scenario, scene, plan, seed=seed, perturbation=USUAL)
    found = judged(outcome)
    result = REFUTED if found["refuted"] or found["contacts"] else COMPLETED if found["completed"] else FAILED
    return found | {
        "outcome": result,
        "run_cpu_seconds": round(time.process_time() - began, 1),
    }
