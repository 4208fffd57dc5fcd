"""Kernels: numba functions, compiled once and cached on disk, and the sentinel values that they share."""

import os
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import cache
from pathlib import Path
from typing import Any, ClassVar, TypeAlias, TypeVar, cast

import numpy as np

F = TypeVar("F", bound=Callable[..., Any])

Integer: TypeAlias = "int | np.integer[Any]"

INTERPRETED_S = 0.4
"""Total CPU time for which kernels run in Python if machine code is on disk, s: loading it takes longer."""

UNCOMPILED_S = 5.0
"""Total CPU time for which kernels run in Python without machine code on disk, s: compiling takes longer."""

INTERPRETED_STATES = 3000
"""Most states of a product that is searched in Python."""

SEARCH_CODE = "label_search.run-*.nbi"
"""Pattern of the files with the machine code of a search."""

INFINITE = 2**60
"""Cost-to-go where there is no path. A search that meets a cost this large starts again with Python's integers."""

NO_EDGE = 2**61
"""Cost of an edge that does not exist; larger than any finite cost-to-go plus the cost of an edge."""

UNREACHABLE = 2**29
"""INFINITE in tables of 32-bit entries; sums of three fit. With 64 bits a front of eight tasks takes a tenth longer."""

UNBOUNDED = 2**62
"""A bound that no cost or mu reaches: a label's value plus what one step adds is less than 2^61."""


class Kernel:
    """A function that runs in Python until all kernels are compiled: small problems are solved sooner than numba loads.

    Attributes:
        function: the function in Python.
        options: options of `numba.njit`.
        compiled: the compiled function; None until there is one.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        """Take a function, and how to compile it."""
        self.function, self.options = function, options
        self.compiled: Callable[..., Any] | None = None
        _kernels.append(self)

    def __call__(self, *arguments: Any) -> Any:
        """Call the function; once kernels have run in Python for long enough, compile them first."""
        if _interpreter.is_running and self.compiled is None:
            return self.function(*arguments)
        if _interpreter.seconds_left <= 0:
            compile_kernels()
        if self.compiled is None:
            with _compiling:  # meanwhile no other thread compiles what this one calls
                if self.compiled is None:
                    return self._interpret(arguments)
        assert self.compiled is not None
        if "no_cpython_wrapper" in self.options and self.compiled is not self.function:
            # It would crash.
            raise TypeError(f"{self.function.__name__}: compiled, only kernels may call it")
        return self.compiled(*arguments)

    def _interpret(self, arguments: Sequence[Any]) -> Any:
        """Call the function in Python, and all kernels that it calls."""
        began, _interpreter.is_running = time.thread_time(), True
        try:
            with np.errstate(over="ignore"):  # as in compiled code
                return self.function(*arguments)
        finally:
            _interpreter.is_running = False
            Interpreter.seconds_left -= time.thread_time() - began

    def compile(self) -> None:
        """Make the compiled function; with `NUMBA_DISABLE_JIT=1`, for a debugger, it is the function in Python."""
        import numba  # takes half a second

        # No divisor is 0, so divisors are not checked: that would take a twentieth of the time of compiling.
        dispatcher = numba.njit(cache=True, nogil=True, error_model="numpy", **self.options)(self.function)
        if dispatcher is not self.function:
            forget_outdated(Path(dispatcher.stats.cache_path))
        self.compiled = dispatcher


def _has_machine_code() -> bool:
    """Return whether the machine code of a search is on disk, as far as can be told without numba."""
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    folder = Path(chosen) if chosen else Path(__file__).parents[1] / "search" / "__pycache__"
    return any(folder.rglob(SEARCH_CODE))


class Interpreter(threading.local):
    """State of the kernels that run in Python.

    Attributes:
        seconds_left: CPU time left, in all threads, before kernels are compiled, s.
        is_running: whether a kernel runs in Python in this thread; those that it calls do, too.
    """

    seconds_left: ClassVar[float] = INTERPRETED_S if _has_machine_code() else UNCOMPILED_S
    is_running: bool = False


_kernels: list[Kernel] = []
_interpreter = Interpreter()
_compiling = threading.RLock()

loading: Callable[[], AbstractContextManager[None]] = nullcontext
"""Returns the context in which numba is loaded; a program may set it to say what takes time."""


def compile_kernels() -> None:
    """Replace all kernels, everywhere in this package, by compiled functions; these compile when they are called."""
    with _compiling:
        waiting = [kernel for kernel in _kernels if kernel.compiled is None]
        if not waiting:
            return
        Interpreter.seconds_left = 0.0
        with loading():
            for one in waiting:
                one.compile()
            package = __name__.partition(".")[0]
            for module in [module for name, module in sys.modules.items() if name.partition(".")[0] == package]:
                names = {name: value for name, value in vars(module).items() if isinstance(value, Kernel)}
                vars(module).update({name: value.compiled for name, value in names.items()})


def is_interpreted() -> bool:
    """Return whether kernels still run in Python: then one call should do little work."""
    return _interpreter.seconds_left > 0


def kernel(function: F) -> F:
    """Compile a function that may allocate arrays."""
    return _kernel(function)


def bare_kernel(function: F) -> F:
    """Compile a function that allocates no arrays, without reference counting, which takes half the time."""
    return _kernel(function, _nrt=False)


def inner_kernel(function: F) -> F:
    """Compile a function as `bare_kernel` does, but for other kernels alone, and inline it into them.

    Inlining avoids passing tuples of arrays, which saves another third of the time. As Python cannot call the function,
    compiling takes a fifth less time.
    """
    return _kernel(function, _nrt=False, forceinline=True, no_cpython_wrapper=True)


def _kernel(function: F, **options: Any) -> F:
    # No C code calls a kernel.
    made = Kernel(function, {"no_cfunc_wrapper": True, **options})
    if not is_interpreted():
        made.compile()
    return cast(F, made.compiled or made)


KERNEL_SOURCES = (
    "models/kernels.py",
    "models/manipulation/slots.py",
    "models/manipulation/successors.py",
    "product/*.py",
    "heuristics/*.py",
    "search/**/*.py",
)
"""Files of `prefplan` that hold all kernels and the constants that these use."""


@cache
def _digest_of_sources() -> str:
    import hashlib

    digest = hashlib.sha256()
    root = Path(__file__).parents[1]
    for source in sorted(source for pattern in KERNEL_SOURCES for source in root.glob(pattern)):
        digest.update(source.read_bytes())
    return digest.hexdigest()


def forget_outdated(folder: Path) -> None:
    """Remove machine code of outdated sources: numba checks a function's own file only, not those of its callees."""
    stamp = folder / "sources.sha256"
    if not stamp.exists() or stamp.read_text() != _digest_of_sources():
        folder.mkdir(parents=True, exist_ok=True)
        for index in folder.glob("*.nbi"):
            index.unlink(missing_ok=True)
        temporary = folder / f"{stamp.name}.{os.getpid()}"
        temporary.write_text(_digest_of_sources())
        temporary.rename(stamp)
