"""Start of the program: libraries that load, are missing, or are still to be compiled."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from types import FrameType

from experiments.cli.status import FAILED, INTERRUPTED, tell

SIMULATION = "pip install '.[sim]', in a clone of prefplan"
"""Installs the simulation."""


UNNEEDED = ("cffi", "scipy.linalg.cython_blas", "yaml")
"""What numba loads in 0.2 s where it is installed: no kernel calls C, multiplies matrices or has a file of settings."""


INTERPRETED_S = 5
"""Time for a search in Python while nothing is compiled, s; compiling takes longer."""

ATTEMPT = "PREFPLAN_INTERPRETED"
"""Environment variable: "1" while a search in Python is tried, "0" when that took too long."""


def load_planner(*, quiet: bool = False) -> None:
    """Load the planner; print on stderr that compiling takes a minute, if it is not compiled and `quiet` is False."""
    with loading():
        with _hidden(UNNEEDED):
            import numba.core.typing.cffi_utils
            import numba.np.arraymath  # noqa: F401
        from prefplan.warm_up import is_compiled

    if not quiet and not is_compiled():
        tell("compiling the search, once; this takes 10 to 30 seconds")


@contextmanager
def planner_at_once(*, quiet: bool, is_program: bool) -> Iterator[None]:
    """Load the planner for a search that prints nothing before it ends; while nothing is compiled, search in Python.

    Kernels give the same plans as Python functions. If nothing is compiled, the program starts itself again with these;
    if the search takes longer than `INTERPRETED_S`, once more with kernels.

    Args:
        quiet: whether to print nothing on stderr.
        is_program: whether this process is the program, and may be replaced.
    """
    attempt = os.environ.get(ATTEMPT)
    if attempt is None and is_program:
        with loading():
            from prefplan.warm_up import is_compiled
        if not is_compiled():
            if not quiet:
                tell(f"nothing is compiled yet: searching in Python for up to {INTERPRETED_S} seconds")
            _start_again({"NUMBA_DISABLE_JIT": "1", ATTEMPT: "1"})
    if attempt == "1":
        signal.signal(signal.SIGALRM, lambda number, frame: _start_again({"NUMBA_DISABLE_JIT": "0", ATTEMPT: "0"}))
        signal.alarm(INTERPRETED_S)
    load_planner(quiet=quiet)
    try:
        yield
    finally:
        signal.alarm(0)


def _start_again(environment: Mapping[str, str]) -> None:
    """Replace this process by the same program with the same arguments."""
    os.execve(sys.executable, [sys.executable, *sys.orig_argv[1:]], os.environ | environment)


@contextmanager
def _hidden(names: Iterable[str]) -> Iterator[None]:
    """Let modules that are not loaded yet seem not to be installed."""
    hidden = [name for name in names if name not in sys.modules]
    sys.modules.update(dict.fromkeys(hidden))  # type: ignore[arg-type]
    try:
        yield
    finally:
        for name in hidden:
            del sys.modules[name]


@contextmanager
def loading() -> Iterator[None]:
    """End the process at once on Ctrl-C: while libraries load, they drop a KeyboardInterrupt or print a traceback."""
    before = signal.signal(signal.SIGINT, _end)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _end(number: int, frame: FrameType | None) -> None:
    tell("interrupted")
    os._exit(INTERRUPTED)


def missing(error: ModuleNotFoundError, *, command: str | None = None) -> int:
    """Print on stderr how to install the library that a command needs, and return the exit status."""
    if error.name == "mujoco":  # what `sim` loads first
        tell(f"{command} needs the simulation: {SIMULATION}")
    else:
        mend = f"{sys.executable} -m pip install {error.name}"
        tell(f"the Python package {error.name} is missing; install it: {mend}")
    return FAILED
