"""The log of a run: one file to check everything that is said of the run.

It is a NumPy archive: the arrays of `Log` under their names, and everything else as JSON under `about`.
"""

from __future__ import annotations

import io
import json
import zipfile
import zlib
from dataclasses import asdict, dataclass, fields
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter, ValidationError

from prefplan.claims import Claims
from prefplan.exact_costs import exact, to_number
from prefplan.models.manipulation.action_costs import ActionCosts, MeasuredCosts
from sim.errors import LogError
from sim.simulation.rollout import FRAME_RATE, Event, Frames, Rollout, Step
from sim.world.scene import Scene

FORMAT = 2
"""Raised whenever older files can no longer be read."""

RATES = ("accelerations", "jerks", "torque_rates")
"""Names of the arrays of rates of the joints."""

ARRAYS = {
    "times": (),
    "qpos": (None,),
    "glow": (),
    "speeds": (None,),
    "torques": (None,),
    **dict.fromkeys(RATES, (None,)),
    "pad_forces": (2,),
}
"""Names of the arrays, and the shape of each row."""

DECIMALS, RATE_DECIMALS = 7, 3
"""Decimals of recorded values: a tenth of a micrometre. Further ones are noise, and a third of the file."""


@dataclass(frozen=True)
class LoggedAction:
    """An action as it was carried out.

    Attributes:
        action: e.g. `transport blue san`.
        start: simulated time at which it began, s.
        end: simulated time at which it ended, s.
        cost: by the model.
        label: the propositions that were observed afterwards, sorted.
    """

    action: str
    start: float
    end: float
    cost: int | float
    label: tuple[str, ...]


@dataclass(frozen=True)
class About:
    """All of a log but its arrays.

    Attributes:
        program: version of prefplan that wrote it.
        scenario: the scenario's name.
        text: the scenario file.
        measured: cost of each (kind, hand before, hand after) where the scenario takes them from measurements.
        robot: which robot was simulated.
        meshes: whether it collided with meshes rather than plain shapes.
        setting: seed, perturbation, faults and whatever else made this run differ from others.
        joints: name and place in `qpos` of each joint.
        actions: in order, failed attempts included.
        events: in order of time.
        claims: what is said to have been achieved.
    """

    program: str
    scenario: str
    text: str
    measured: tuple[tuple[str, str, str, int | float], ...]
    robot: str
    meshes: bool
    setting: dict[str, Any]
    joints: dict[str, int]
    actions: tuple[LoggedAction, ...]
    events: tuple[Event, ...]
    claims: Claims


@dataclass(frozen=True, kw_only=True)
class Log(Frames):
    """The record of a run, and the claims about it.

    Attributes:
        about: everything but the arrays.
    """

    about: About


def log_of(
    scene: Scene, rollout: Rollout, claims: Claims, *, scenario: str, text: str, setting: dict[str, Any] | None = None
) -> Log:
    """Return the log of a rollout, up to the end of its last action if it was not completed (see `About`)."""
    model, steps = scene.mujoco, rollout.steps
    end = np.inf if rollout.completed else max([0.0, *(step.end for step in steps)]) + 1 / FRAME_RATE
    joints = [model.joint(i) for i in range(model.njnt)]
    about = About(
        program=version("prefplan"),
        scenario=scenario,
        text=text,
        measured=_measured(scene.model.costs),
        robot=scene.robot.name,
        meshes=scene.dressed,
        setting=setting or {},
        joints={joint.name: int(joint.qposadr[0]) for joint in joints},
        actions=tuple(_logged(step) for step in steps),
        events=tuple(event for event in rollout.events if event.time <= end),
        claims=claims,
    )
    decimals = dict.fromkeys(ARRAYS, DECIMALS) | dict.fromkeys(RATES, RATE_DECIMALS)
    kept = {name: getattr(rollout, name)[rollout.times <= end] for name in ARRAYS}
    return Log(
        about=about,
        **{name: rows if name == "times" else rows.round(decimals[name]) for name, rows in kept.items()},
    )


def _logged(step: Step) -> LoggedAction:
    cost = to_number(exact(step.cost))
    return LoggedAction(step.action, step.start, step.end, cost, tuple(sorted(step.observed.label)))


def _measured(costs: ActionCosts) -> tuple[tuple[str, str, str, int | float], ...]:
    if not isinstance(costs, MeasuredCosts):
        return ()
    return tuple((*pair, to_number(exact(cost))) for pair, cost in costs.entries.items())


def encode(log: Log) -> bytes:
    """Return a log as the contents of its file."""
    about = json.dumps({"format": FORMAT} | asdict(log.about)).encode()
    file = io.BytesIO()
    arrays = {name: getattr(log, name) for name in ARRAYS}
    np.savez_compressed(file, about=np.frombuffer(about, dtype=np.uint8), **arrays)
    return file.getvalue()


def read_log(path: str | Path) -> Log:
    """Read a log.

    Raises:
        LogError: the file is missing, broken, no log or of another format; the message names the file.
    """
    try:
        with np.load(path, allow_pickle=False) as archive:
            found = {name: archive[name] for name in archive.files}
        about = _about(path, found["about"])
    except (FileNotFoundError, IsADirectoryError, PermissionError) as error:
        raise LogError(f"{path}: {str(error.strerror).lower()}") from None
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError, TypeError, KeyError, NotImplementedError):
        raise LogError(f"{path}: broken, or not a log of `prefplan run`") from None
    arrays = {}
    for name, row in ARRAYS.items():
        if name not in found:
            raise LogError(f"{path}: broken: {name} is missing")
        arrays[name] = array = found[name]
        wanted = (len(found["times"]), *row)
        if array.ndim != len(wanted) or any(n not in (m, None) for m, n in zip(array.shape, wanted, strict=True)):
            raise LogError(f"{path}: broken: {name} has the shape {array.shape}")
        if array.dtype.kind not in "fi" or not np.isfinite(array).all():
            raise LogError(f"{path}: broken: {name} holds what is not a number")
    if not len(arrays["times"]):
        raise LogError(f"{path}: broken: not a single frame")
    return Log(about=about, **arrays)


def _about(path: str | Path, data: np.ndarray) -> About:
    try:
        about = json.loads(data.tobytes())
        if about["format"] != FORMAT:
            raise LogError(f"{path}: a log of format {about['format']!r}; this version of prefplan reads {FORMAT}")
        about = TypeAdapter(About).validate_python({field.name: about[field.name] for field in fields(About)})
    except KeyError as error:
        raise LogError(f"{path}: broken: about.{error.args[0]} is missing") from None
    except ValidationError as error:
        problem = error.errors()[0]
        where = ".".join(str(part) for part in problem["loc"])
        raise LogError(f"{path}: broken: about.{where}: {problem['msg'].lower()}") from None
    except (ValueError, TypeError):
        raise LogError(f"{path}: broken: about is not the JSON it should be") from None
    return about
