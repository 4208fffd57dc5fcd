"""Start of the program: libraries are loaded, or reported as missing or still to be compiled."""

import os
import resource
import signal
import sys
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib.util import find_spec
from types import FrameType

from experiments.cli.status import FAILED, is_quiet, tell
from prefplan.errors import LimitError

UNNEEDED = ("cffi", "scipy.linalg.cython_blas", "yaml")
"""Modules that numba loads in 0.2 s if installed: no kernel calls C, multiplies matrices or has a file of settings."""

CLEARED_LINE = "\033[K"
"""Clears a terminal's line from the cursor on."""

LEAST_ADDRESS_SPACE = 3 * 2**29
"""Least limit of the virtual memory, bytes, with which numba loads; with less, LLVM ends the process."""

LOADING_POLL_S = 0.05
"""Time after which a Ctrl-C that came while a library loads is tried again, s."""

WAITING = "Ctrl-C while a library loads"
"""Name of the thread that tries a Ctrl-C again."""

LOADING = ("<frozen importlib", "/numba/core/serialize.py", "/llvmlite/")
"""Parts of the names of source files whose functions load a library or a compiled kernel."""


def has_simulation() -> bool:
    """Return whether the libraries that move the arm are installed; a damaged one may still fail to load."""
    return all(map(find_spec, ("mujoco", "mink")))


def load_planner() -> None:
    """Let stderr say, without `-q`, if the kernels must be compiled once they are loaded: it takes 10 to 30 seconds."""
    from prefplan.models import kernels

    kernels.loading = partial(_loading_numba, is_quiet())


@contextmanager
def _loading_numba(quiet: bool) -> Iterator[None]:
    """Load numba without what it does not need; once its functions are made, say if they are still to be compiled.

    Raises:
        LimitError: `ulimit -v` leaves no room for numba; a message says so.
    """
    allowed, _ = resource.getrlimit(resource.RLIMIT_AS)
    if 0 <= allowed < LEAST_ADDRESS_SPACE:
        needed = f"{allowed / 2**20:.0f} MiB of virtual memory are allowed, {LEAST_ADDRESS_SPACE / 2**20:.0f} needed"
        tell(f"ulimit -v: {needed}")
        raise LimitError("memory")
    with _hidden(UNNEEDED):
        import numba.core.typing.cffi_utils
        import numba.np.arraymath  # noqa: F401
    yield
    from prefplan.warm_up import is_compiled

    if not quiet and not is_compiled():
        tell("compiling the search, once; this takes 10 to 30 seconds")


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
def loading_simulation() -> Iterator[None]:
    """On a terminal, show a temporary line while the simulation loads, unless `-q` is given."""
    shown = not is_quiet() and sys.stderr.isatty()
    if shown:
        print("loading the simulation ...", end="\r", file=sys.stderr, flush=True)
    try:
        yield
    finally:
        if shown:
            print(CLEARED_LINE, end="", file=sys.stderr, flush=True)


def open_streams() -> None:
    """Open on /dev/null what the caller has closed, such as stdout with `>&-`; else a file would take its number."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode))


def handle_ctrl_c() -> None:
    """From now on, let Ctrl-C wait while a library or a compiled kernel loads, unless Ctrl-C is ignored.

    Libraries drop a KeyboardInterrupt while they load, or print a traceback.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)


def _interrupt(number: int, frame: FrameType | None) -> None:
    while frame is not None:
        if any(part in frame.f_code.co_filename for part in LOADING):
            if not any(thread.name == WAITING for thread in threading.enumerate()):
                again = threading.Timer(LOADING_POLL_S, signal.pthread_kill, [threading.main_thread().ident, number])
                again.name, again.daemon = WAITING, True
                again.start()
            return
        frame = frame.f_back
    raise KeyboardInterrupt


def missing(error: ModuleNotFoundError, *, command: str | None = None) -> int:
    """Print on stderr how to install the library that a command needs, and return the exit status."""
    if error.name in ("lazy_loader", "mujoco"):  # what `sim` loads first
        tell(f"{command} needs the simulation: pip install '.[sim]', in a clone of prefplan")
    else:
        fix = f"{sys.executable} -m pip install {error.name}"
        tell(f"the Python package {error.name} is missing; install it: {fix}")
    return FAILED
