"""The log of a run: one file from which every claim about the run can be checked.

It is a NumPy archive: the arrays of `Log` under their names, most of them packed (second differences of neighbouring
rows, column by column), and everything else as JSON under `about`.
"""

import functools
import hashlib
import io
import json
import math
import platform
import zipfile
import zlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter, ValidationError

from prefplan.claims import Claims
from prefplan.exact_costs import exact, to_number
from prefplan.models.costs import by_name
from prefplan.models.manipulation.action_costs import ActionCosts, MeasuredCosts, cost_names
from sim.errors import LogError
from sim.external.bundle import packed
from sim.simulation.run import FRAME_RATE_HZ, Event, Frames, Run, Step
from sim.world.scene import Scene

FORMAT = 4
"""Version of the file format; raised when older files can no longer be read."""

EVENTS = {"fault", "contact", "mismatch", "retry", "replan", "unaffected", "ended"}
"""Kinds of events in a log: what went wrong, and what was done about it. The frames show everything else."""

ORDER = 2
"""Order of the differences between neighbouring rows: motion at constant velocity becomes zeros."""

ARRAYS = {"times": 1, "qpos": 2, "qvel": 2, "glow": 1}
"""Names of the arrays with a row for each frame, and their numbers of dimensions. The arm's loads are left out: they
follow from the commands."""

MORE_ARRAYS = {"controls": 2, "interventions": 2}
"""Names of the arrays with other rows, and their numbers of dimensions."""

DECIMALS = 7
"""Decimals of states that are kept: a tenth of a micrometre. Further ones are noise that fills a third of the file."""

MAX_BYTES = 2**29
"""Greatest size of all arrays of a log: more than an hour of the simulated arm."""

MAX_NAME = 40
"""Most characters of a foreign name in a message."""

PACKED = {"qpos": 10**DECIMALS, "qvel": 10**DECIMALS, "controls": 1}
"""Scales of the arrays that are packed."""


@dataclass(frozen=True)
class LoggedAction:
    """An action as it was carried out.

    Attributes:
        action: e.g. `transport blue san`.
        start: simulated time at which it began, s.
        end: simulated time at which it ended, s.
        cost: of the action in the scenario.
        label: the propositions that were observed afterwards, sorted.
    """

    action: str
    start: float
    end: float
    cost: int | float
    label: tuple[str, ...]


@dataclass(frozen=True)
class About:
    """Everything in a log except its arrays.

    Attributes:
        versions: of prefplan, MuJoCo, NumPy and Python, and the kind of machine that wrote it.
        scenario: the scenario's name.
        text: the scenario file.
        measured: cost of each (kind, hand before, hand after) if the scenario has measured costs.
        robot: name of the simulated robot.
        setting: seed, perturbation and faults of the run, and whether it was interrupted.
        joints: index of each joint in `qpos`, by name.
        actions: in order, failed attempts included.
        events: of the kinds in `EVENTS`, in order of time.
        claims: about what was achieved.
        files: contents of the other files that the scenario names, in base64, by path.
    """

    versions: dict[str, str]
    scenario: str
    text: str
    measured: tuple[tuple[str, str, str, int | float], ...]
    robot: str
    setting: dict[str, Any]
    joints: dict[str, int]
    actions: tuple[LoggedAction, ...]
    events: tuple[Event, ...]
    claims: Claims
    files: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Log(Frames):
    """The record of a run, and the claims about it.

    Attributes:
        about: everything but the arrays.
        sha256: hash of the file that it was read from; empty for none.
    """

    about: About
    sha256: str = ""


def log_of(
    scene: Scene, run: Run, claims: Claims, *, scenario: str, text: str, setting: dict[str, Any] | None = None
) -> Log:
    """Return the log of a run, up to the end of its last action if it was not completed (see `About`)."""
    model = scene.mujoco
    end = np.inf if run.completed else max([0.0, *(step.end for step in run.steps)]) + 1 / FRAME_RATE_HZ
    joints = [model.joint(i) for i in range(model.njnt)]
    about = About(
        versions=versions(),
        scenario=scenario,
        text=text,
        measured=measured_costs(scene.model.costs),
        robot=scene.robot.name,
        setting=setting or {},
        joints={joint.name: int(joint.qposadr[0]) for joint in joints},
        actions=tuple(_logged(step) for step in run.steps),
        events=tuple(event for event in run.events if event.kind in EVENTS and event.time <= end),
        claims=claims,
        files=packed(scene.model),
    )
    kept = {name: getattr(run, name)[run.times <= end] for name in ARRAYS}
    whole = len(kept["times"]) == len(run.times)
    steps = len(run.controls) if whole else round(kept["times"][-1] / model.opt.timestep)
    kept["controls"] = run.controls[:steps]
    kept["interventions"] = run.interventions[run.interventions[:, 0] < max(steps, 1)]
    kept |= {name: kept[name].round(DECIMALS) for name in ("qpos", "qvel")}
    return Log(about=about, **kept)


@functools.cache
def versions() -> dict[str, str]:
    """Return the versions and the kind of machine that a simulation depends on."""
    names = {name: version(name) for name in ("prefplan", "mujoco", "numpy")}
    return names | {"python": platform.python_version(), "machine": f"{platform.system()} {platform.machine()}"}


def _logged(step: Step) -> LoggedAction:
    cost = to_number(exact(step.cost))
    return LoggedAction(step.action, step.start, step.end, cost, tuple(sorted(step.observed.label)))


def measured_costs(costs: ActionCosts | None) -> tuple[tuple[str, str, str, int | float], ...]:
    """Return each (kind, hand before, hand after) with the first of its costs; nothing if costs are not measured."""
    if not isinstance(costs, MeasuredCosts):
        return ()
    name = cost_names(costs)[0]
    return tuple((*pair, to_number(exact(by_name(cost)[name]))) for pair, cost in costs.entries.items())


def encode(log: Log) -> bytes:
    """Return a log as the contents of its file."""
    about = json.dumps({"format": FORMAT} | asdict(log.about)).encode()
    file = io.BytesIO()
    arrays = {name: getattr(log, name) for name in (*ARRAYS, *MORE_ARRAYS)}
    arrays |= {name: pack(arrays[name], scale=scale) for name, scale in PACKED.items()}
    np.savez_compressed(file, about=np.frombuffer(about, dtype=np.uint8), **arrays)
    return file.getvalue()


def read_log(path: str | Path) -> Log:
    """Read a log.

    Raises:
        LogError: the file is missing, broken, no log, too large or of another format; the message names the file.
    """
    found, sha256 = _arrays(path)
    if "about" not in found:
        raise LogError(f"{path}: broken, or not a log of `prefplan run`")
    about = _about(path, found["about"])
    arrays = {}
    for name, dimensions in (ARRAYS | MORE_ARRAYS).items():
        if name not in found:
            raise LogError(f"{path}: broken: {name} is missing")
        array = found[name]
        kinds = (np.int64,) if name in PACKED else (np.int64, np.float64)
        if array.dtype not in kinds or not np.isfinite(array).all():
            raise LogError(f"{path}: broken: {name} holds what is not a number")
        frames = array.shape[-1] if array.ndim else 0  # packed arrays are transposed
        if array.ndim != dimensions or (name in ARRAYS and frames != len(found["times"])):
            raise LogError(f"{path}: broken: {name} has the shape {array.shape}")
        arrays[name] = unpack(array, scale=PACKED[name]) if name in PACKED else array
    if not len(arrays["times"]):
        raise LogError(f"{path}: broken: not a single frame")
    return Log(about=about, sha256=sha256, **arrays)


def _arrays(path: str | Path) -> tuple[dict[str, np.ndarray], str]:
    """Return the arrays in a log's file, by name, and its SHA-256; raise `LogError` if it has other or larger parts.

    Nothing is unpacked beyond the size in the archive's directory, even if an array's header claims more.
    """
    try:
        with open(path, "rb") as file:
            with zipfile.ZipFile(file) as archive:
                _check_parts(path, archive.infolist())
            file.seek(0)
            sha256 = hashlib.file_digest(file, "sha256").hexdigest()
            file.seek(0)
            with np.load(file, allow_pickle=False) as arrays:
                return dict(arrays), sha256
    except (FileNotFoundError, IsADirectoryError, PermissionError) as error:
        raise LogError(f"{path}: {str(error.strerror).lower()}") from None
    except MemoryError:
        raise LogError(f"{path}: broken: it claims to be larger than the memory") from None
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError, TypeError, RuntimeError):
        raise LogError(f"{path}: broken, or not a log of `prefplan run`") from None


def _check_parts(path: str | Path, parts: Sequence[zipfile.ZipInfo]) -> None:
    left = {f"{name}.npy" for name in ("about", *ARRAYS, *MORE_ARRAYS)}
    for part in parts:
        if part.filename not in left:
            raise LogError(f"{path}: not a log of `prefplan run`: it holds {part.filename[:MAX_NAME]!r}")
        left.remove(part.filename)
    if (size := sum(part.file_size for part in parts)) > MAX_BYTES:
        raise LogError(f"{path}: too large: its arrays have {size / 2**20:.0f} MiB, {MAX_BYTES / 2**20:.0f} at most")


def _finite(text: str) -> float:
    """Return a number; JSON has no infinite ones, but Python reads them."""
    if not math.isfinite(number := float(text)):
        raise ValueError
    return number


def _about(path: str | Path, data: np.ndarray) -> About:
    try:
        about = json.loads(data.tobytes(), parse_float=_finite, parse_constant=_finite)
        if (found := about.get("format")) != FORMAT:
            raise LogError(f"{path}: a log of format {found!r}; this version of prefplan reads {FORMAT}")
        return TypeAdapter(About).validate_python(about)
    except ValidationError as error:
        problem = error.errors()[0]
        where = ".".join(str(part) for part in problem["loc"])
        raise LogError(f"{path}: broken: about.{where}: {problem['msg'].lower()}") from None
    except (MemoryError, RecursionError):
        raise LogError(f"{path}: broken: it claims to be larger than the memory, or is nested too deep") from None
    except (ValueError, TypeError, AttributeError):
        raise LogError(f"{path}: broken: about is not the JSON it should be") from None


def pack(rows: np.ndarray, *, scale: int = 1) -> np.ndarray:
    """Return (T, ...) rows, scaled and rounded, as (..., T) integer differences that compress well.

    Args:
        rows: numbers whose scaled values are below 2**60.
        scale: factor from the numbers to the integers.
    """
    columns = np.rint(rows * scale).astype(np.int64).T
    zeros = np.zeros((*columns.shape[:-1], ORDER), dtype=np.int64)
    return np.diff(columns, n=ORDER, axis=-1, prepend=zeros)


def unpack(columns: np.ndarray, *, scale: int = 1) -> np.ndarray:
    """Return the rows that `pack` was given: integers for a scale of 1, otherwise floats."""
    sums = columns.astype(np.int64)
    for _ in range(ORDER):
        sums = np.cumsum(sums, axis=-1)
    rows = np.ascontiguousarray(sums.T)
    return rows if scale == 1 else rows / scale
