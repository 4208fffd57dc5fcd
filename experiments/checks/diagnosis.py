"""What works on this machine: each check really uses one part, and names the command that repairs it."""

import os
import platform
import shlex
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from experiments.cli.start import has_simulation

OK, WARNING, PROBLEM = "ok", "warning", "problem"

ENCODING_TIMEOUT_S = 60.0

ENCODING = ["-f", "lavfi", "-i", "testsrc=size=64x64:rate=5:duration=1", "-c:v", "libx264", "-f", "null", "-"]
"""Arguments of ffmpeg that encode one second of video with the codec of all videos, and discard it."""

INSTALL_GL = "sudo apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri"
"""Installs a software renderer on Debian and Ubuntu."""


@dataclass(frozen=True)
class Diagnosis:
    """Result of a check.

    Attributes:
        name: the part that was checked.
        status: `ok`, `warning` (an optional part is missing) or `problem` (a needed part does not work).
        found: the version or path of the part, or what is wrong.
        fix: the command that repairs it; None if nothing is wrong or no command is known.
    """

    name: str
    status: str
    found: str
    fix: str | None = None


def python() -> Diagnosis:
    """Which Python runs this."""
    return Diagnosis("python", OK, f"{platform.python_version()} ({sys.executable})")


def planner() -> Diagnosis:
    """Whether the search is compiled, and its machine code can be cached."""
    from prefplan.warm_up import code_folder, is_compiled

    cache = code_folder() or Path()
    existing = next(folder for folder in (cache, *cache.parents) if folder.exists())
    if not os.access(existing, os.W_OK):
        fix = 'export NUMBA_CACHE_DIR="$HOME/.cache/numba"'
        return Diagnosis("planner", WARNING, f"{cache} cannot be written to: every start compiles again", fix)
    if not is_compiled():
        fix = f"{sys.executable} -m prefplan.warm_up"
        return Diagnosis("planner", WARNING, "not compiled yet: the first plan takes 10 to 30 seconds longer", fix)
    return Diagnosis("planner", OK, f"compiled (numba {version('numba')}, cache {cache})")


def simulation() -> Diagnosis:
    """Whether the simulation is installed and can be loaded."""
    if not has_simulation():
        fix = "pip install '.[sim]'"
        return Diagnosis("simulation", WARNING, "optional: not installed; in a clone of prefplan", fix)
    try:
        import sim.execution.executor  # noqa: F401
    except Exception as error:  # a damaged library may raise anything
        fix = _pip_install("--force-reinstall", "mujoco", "mink")
        return Diagnosis("simulation", PROBLEM, f"cannot be loaded: {error}", fix)
    return Diagnosis("simulation", OK, f"MuJoCo {version('mujoco')}, mink {version('mink')}")


def rendering() -> Diagnosis:
    """Whether OpenGL can render."""
    from sim.errors import RenderingError
    from sim.rendering.opengl import check_rendering

    chosen = os.environ.get("MUJOCO_GL")
    try:
        check_rendering()
    except RenderingError as error:
        fix = "unset MUJOCO_GL" if chosen else INSTALL_GL
        return Diagnosis("rendering", PROBLEM, str(error).partition(";")[0], fix)
    return Diagnosis("rendering", OK, f"OpenGL works{f' (MUJOCO_GL={chosen})' if chosen else ''}")


def ffmpeg() -> Diagnosis:
    """Whether a video can be encoded."""
    chosen = os.environ.get("IMAGEIO_FFMPEG_EXE")
    fix = "unset IMAGEIO_FFMPEG_EXE" if chosen else _pip_install("--force-reinstall", "imageio-ffmpeg")
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        program = get_ffmpeg_exe()
        command = [program, "-v", "error", *ENCODING]
        subprocess.run(command, check=True, capture_output=True, timeout=ENCODING_TIMEOUT_S)
    except (ImportError, RuntimeError, OSError, subprocess.SubprocessError) as error:
        return Diagnosis("ffmpeg", PROBLEM, f"cannot encode H.264: {error}", fix)
    return Diagnosis("ffmpeg", OK, f"encodes H.264 ({program})")


def meshes() -> Diagnosis:
    """Whether the meshes of the arm are installed."""
    from sim.robots.arms.panda_meshes import FINISHES, FOLDER
    from sim.robots.assets import asset_folder, unavailable_because

    fix = _pip_install("--force-reinstall", "--no-deps", "gymnasium-robotics")
    if reason := unavailable_because():
        return Diagnosis("meshes", PROBLEM, reason, fix)
    folder = asset_folder(FOLDER)
    missing = [link for link in FINISHES if not (folder / "visual" / f"{link}.stl").is_file()]
    if missing:
        return Diagnosis("meshes", PROBLEM, f"{folder} lacks {', '.join(missing)}", fix)
    return Diagnosis("meshes", OK, f"of all {len(FINISHES)} links ({folder})")


CHECKS: tuple[Callable[[], Diagnosis], ...] = (python, planner, simulation)

SIMULATION_CHECKS: tuple[Callable[[], Diagnosis], ...] = (rendering, ffmpeg, meshes)
"""Checks that need the simulation to load."""


def _pip_install(*arguments: str) -> str:
    return shlex.join([sys.executable, "-m", "pip", "install", *arguments])
