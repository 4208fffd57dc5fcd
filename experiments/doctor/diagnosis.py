"""What works on this machine: each check tries something for real and says what it found."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, metadata, requires, version
from pathlib import Path

from packaging.requirements import Requirement

from experiments.doctor.mending import installs, pip_installs
from prefplan.limits import available_memory

OK, WARNING, PROBLEM = "ok", "warning", "problem"

TIME_LIMIT = 60.0
"""How long a child process may take, s; a library that is loaded for the first time can be slow."""

ENOUGH_MEMORY = 2**30
"""Less free memory than this cuts searches short that are usual, bytes."""

SOFTWARE = "import sim.execution.executor, sim.rendering.video, mujoco; print(mujoco.__version__)"
"""Loads all that simulation and films need; prints MuJoCo's version."""

ENCODING = ["-f", "lavfi", "-i", "testsrc=size=64x64:rate=5:duration=1", "-c:v", "libx264", "-f", "null", "-"]
"""ffmpeg's arguments to encode a second of film, as films are encoded, to nowhere."""


@dataclass(frozen=True)
class Diagnosis:
    """What a check found.

    Attributes:
        name: of what was checked.
        status: `ok`, `warning` (something optional is missing) or `problem` (something needed does not work).
        found: what is there, or what is wrong.
        mend: the command that mends it; None if all is well, or no command is known to be right here.
    """

    name: str
    status: str
    found: str
    mend: str | None = None


Check = Callable[[], list[Diagnosis]]
"""Looks at one thing; most have one finding."""


def python() -> list[Diagnosis]:
    """Which Python runs this."""
    return [Diagnosis("python", OK, f"{platform.python_version()} ({sys.executable})")]


def packages() -> list[Diagnosis]:
    """Whether the packages that prefplan needs are installed, in versions that it works with."""
    wrong = [(need, state) for need in _needs() if not need.marker or need.marker.evaluate() if (state := _state(need))]
    if wrong:
        text = ", ".join(f"{need.name} is {state}" for need, state in wrong)
        return [Diagnosis("packages", PROBLEM, text, pip_installs(*(_bare(need) for need, _ in wrong)))]
    return [Diagnosis("packages", OK, "all that prefplan needs are installed")]


def extras() -> list[Diagnosis]:
    """Which optional parts are installed, a finding each."""
    parts: dict[str, list[Requirement]] = {}
    for need in _needs():
        for extra in sorted(_extras()):
            if need.marker and need.marker.evaluate({"extra": extra}) and not need.marker.evaluate():
                parts.setdefault(extra, []).append(need)
    found = []
    for extra, needs in parts.items():
        missing = [(need, state) for need in needs if (state := _state(need))]
        if missing:
            text = ", ".join(f"{need.name} is {state}" for need, state in missing)
            mend = pip_installs(*(_bare(need) for need, _ in missing))
            found.append(Diagnosis(extra, WARNING, f"optional: {text}", mend))
        else:
            found.append(Diagnosis(extra, OK, ", ".join(f"{need.name} {version(need.name)}" for need in needs)))
    return found


def _needs() -> list[Requirement]:
    try:
        return [Requirement(line) for line in requires("prefplan") or ()]
    except PackageNotFoundError:
        return []


def _extras() -> set[str]:
    """Return the names of the extras that a user, not a developer, might want."""
    try:
        return set(metadata("prefplan").get_all("Provides-Extra") or ()) - {"dev"}
    except PackageNotFoundError:
        return set()


def _state(need: Requirement) -> str | None:
    """Return what is wrong with a required package, or None."""
    try:
        there = version(need.name)
    except PackageNotFoundError:
        return "missing"
    if need.specifier.contains(there, prereleases=True):
        return None
    return f"of version {there}, not {need.specifier}"


def _bare(need: Requirement) -> str:
    """Return a requirement without its marker."""
    return f"{need.name}{need.specifier}"


def planner() -> list[Diagnosis]:
    """Whether the search is compiled, and may be kept so."""
    from prefplan.search import boa_star
    from prefplan.warm_up import is_compiled

    cache = Path(boa_star.run._cache.cache_path)  # type: ignore[attr-defined]
    existing = next(folder for folder in (cache, *cache.parents) if folder.exists())
    if not os.access(existing, os.W_OK):
        mend = 'export NUMBA_CACHE_DIR="$HOME/.cache/numba"'
        return [Diagnosis("planner", WARNING, f"{cache} cannot be written to: every start compiles anew", mend)]
    if not is_compiled():
        mend = f"{sys.executable} -m prefplan.warm_up"
        return [Diagnosis("planner", WARNING, "not compiled yet: the first plan takes a minute longer", mend)]
    return [Diagnosis("planner", OK, f"compiled (numba {version('numba')}, cache {cache})")]


def simulation() -> list[Diagnosis]:
    """Whether all that simulation needs can be loaded."""
    # -P: not from the folder of the call, where something else may be named `sim`.
    text, works = in_a_child([sys.executable, "-P", "-c", SOFTWARE])
    if works:
        return [Diagnosis("simulation", OK, f"MuJoCo {text}, mink {_version('mink')}")]
    needed = pip_installs("--force-reinstall", *(_bare(need) for need in _needs() if need.name in ("mujoco", "mink")))
    return [Diagnosis("simulation", PROBLEM, f"cannot be loaded: {text}", needed if _needs() else None)]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "missing"


def in_a_child(command: list[str], environment: dict[str, str] | None = None) -> tuple[str, bool]:
    """Return the last line that a process prints, on stderr if it fails, and whether it succeeds within the time."""
    here = {"PYTHONPATH": os.pathsep.join(filter(None, [str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH")]))}
    try:
        done = subprocess.run(
            command,
            env=os.environ | here | (environment or {}),
            capture_output=True,
            text=True,
            errors="replace",
            timeout=TIME_LIMIT,
        )
    except subprocess.TimeoutExpired:
        return f"no answer within {TIME_LIMIT:.0f} s", False
    except OSError as error:
        return f"{command[0]} cannot be run ({error.strerror})", False
    lines = (done.stderr if done.returncode else done.stdout).strip().splitlines()
    silent = f"ended with status {done.returncode}" if done.returncode else ""
    return lines[-1] if lines else silent, done.returncode == 0


def ffmpeg() -> list[Diagnosis]:
    """Whether a film can be encoded."""
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        program = get_ffmpeg_exe()
    except (ImportError, RuntimeError) as error:
        return [Diagnosis("ffmpeg", PROBLEM, str(error), pip_installs("--force-reinstall", "imageio-ffmpeg"))]
    text, works = in_a_child([program, "-v", "error", *ENCODING])
    if works:
        return [Diagnosis("ffmpeg", OK, f"encodes H.264 ({program})")]
    chosen = os.environ.get("IMAGEIO_FFMPEG_EXE")
    mend = "unset IMAGEIO_FFMPEG_EXE" if chosen else pip_installs("--force-reinstall", "imageio-ffmpeg")
    return [Diagnosis("ffmpeg", PROBLEM, f"{program} cannot encode H.264: {text}", mend)]


def meshes() -> list[Diagnosis]:
    """Whether the arm's surfaces are installed."""
    mend = pip_installs("--force-reinstall", "--no-deps", "gymnasium-robotics")
    try:
        from sim.robots.meshes import LINKS, mesh_folder
    except (AttributeError, ImportError, OSError, RuntimeError) as error:  # whatever loading MuJoCo may raise
        return [Diagnosis("meshes", WARNING, f"cannot be looked for: {error}")]
    folder = mesh_folder()
    if folder is None:
        return [Diagnosis("meshes", WARNING, "not installed: the arm is drawn as plain capsules", mend)]
    missing = [link for link in LINKS if not (folder / "visual" / f"{link}.stl").is_file()]
    if missing:
        return [Diagnosis("meshes", PROBLEM, f"{folder} lacks {', '.join(missing)}", mend)]
    return [Diagnosis("meshes", OK, f"of all {len(LINKS)} links ({folder})")]


def cores() -> list[Diagnosis]:
    """How many cores this process may use."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return [Diagnosis("cores", OK, str(count))]


def memory() -> list[Diagnosis]:
    """How much memory is free."""
    free = available_memory()
    text = f"{free / 2**30:.1f} GiB free"
    if free < ENOUGH_MEMORY:
        return [Diagnosis("memory", WARNING, f"{text}: long searches may end early")]
    return [Diagnosis("memory", OK, text)]


def browser() -> list[Diagnosis]:
    """Whether there is a browser that pages can be looked at with from the command line."""
    names = ("chromium", "chromium-browser", "google-chrome", "firefox")
    found = next((path for name in names if (path := shutil.which(name))), None)
    if found is None and sys.platform == "darwin":
        return [Diagnosis("browser", OK, "macOS has one")]
    if found is None:
        return [Diagnosis("browser", WARNING, "optional: none to look at pages with", installs("browser"))]
    return [Diagnosis("browser", OK, found)]
