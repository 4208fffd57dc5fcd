"""Limits of time and memory."""

from __future__ import annotations

import errno
import math
import os
import re
import resource
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar, Token
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import TypeVar

import numpy as np

from prefplan.errors import LimitError

T = TypeVar("T")

CHECK_PERIOD_S = 0.05
"""Time between two checks of the limits while a kernel runs, s."""

WATCHED_ENTRIES = 100_000
"""A kernel that fills or reads fewer entries than this is not watched: it takes less than 0.1 s."""

MEMORY_CHECK_PERIOD_S = 0.005
"""Least time between two checks of the memory in use, s; a check takes 0.01 ms."""

CLOCK_PERIOD = 10_000
"""Number of calls of `clocked`, e.g. one for each line of a file, between two checks of the limits: up to 0.2 s."""

MOST_BYTES = 100_000_000
"""Greatest size of a file that is read at once, bytes."""

MEMORY_INFO = Path("/proc/meminfo")
"""Linux's file on the memory (proc_meminfo(5))."""

MEMORY_SHARE = 0.8
"""Share of the free memory that may be used by default."""


def available_memory() -> int:
    """Return the free memory, bytes, with that of cached files; 2 GiB if it is not known."""
    try:
        text = MEMORY_INFO.read_text(encoding="ascii")
    except OSError:
        text = ""
    found = re.search(r"^MemAvailable: +(\d+) kB", text, re.MULTILINE)
    return int(found[1]) * 1024 if found else 2**31


def usable_memory() -> float:
    """Return the part of the free memory that may be used by default, bytes."""
    return MEMORY_SHARE * available_memory()


def memory_in_use() -> int:
    """Return the memory of this process, bytes; its maximum so far if only that is known."""
    try:
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


@dataclass
class Limits:
    """Limits of a search. As a context manager, it sets the limits that `check_limits` checks.

    Limits made in the context of other limits are never wider than what those leave.

    Attributes:
        seconds: limit of the time since this was made, s.
        bytes: limit of the memory allocated since this was made, bytes; by default a share of the free memory.
        interrupted: whether Ctrl-C has ended the work within these limits; see `interruptible`.
    """

    seconds: float = math.inf
    bytes: float = field(default_factory=usable_memory)
    interrupted: bool = False
    _began: float = field(default_factory=time.perf_counter)
    _in_use_before: int = field(default_factory=memory_in_use)
    _outer: Token[Limits | None] | None = None
    _next_memory_check: float = 0

    def __post_init__(self) -> None:
        """Reduce the limits to what is left of the present ones."""
        outer = _present.get()
        if outer is not None:
            self.seconds = min(self.seconds, outer.seconds_left + time.perf_counter() - self._began)
            self.bytes = min(self.bytes, outer.bytes - outer.bytes_taken + self.bytes_taken)

    @classmethod
    def of(cls, seconds: float | None, bytes: float | None) -> Limits:
        """Return limits; a limit that is None has its default."""
        return cls(math.inf if seconds is None else seconds, usable_memory() if bytes is None else bytes)

    @property
    def out_of_time(self) -> bool:
        """Whether the time is up."""
        return self.seconds_left < 0

    @property
    def seconds_left(self) -> float:
        """The time left, s; negative once it is up."""
        return self.seconds - (time.perf_counter() - self._began)

    @property
    def bytes_taken(self) -> int:
        """Memory allocated since this was made, bytes."""
        return memory_in_use() - self._in_use_before

    def check(self, more_bytes: float = 0) -> None:
        """Raise LimitError if the time is up, or if `more_bytes` would exceed the memory limit."""
        if self.out_of_time:
            raise LimitError("time")
        now = time.perf_counter()
        if more_bytes or now >= self._next_memory_check:
            self._next_memory_check = now + MEMORY_CHECK_PERIOD_S
            if self.bytes_taken + more_bytes > self.bytes:
                raise LimitError("memory")

    def __enter__(self) -> Limits:
        """Make these the present limits."""
        self._outer = _present.set(self)
        return self

    def __exit__(self, *error: object) -> None:
        """Restore the limits that were present before."""
        if self._outer is not None:
            _present.reset(self._outer)


_CALLS = count(1)

_present: ContextVar[Limits | None] = ContextVar("limits", default=None)


@contextmanager
def interruptible(limits: Limits) -> Iterator[None]:
    """Work within limits; Ctrl-C ends the work as a limit does, and sets the time left to zero.

    Raises:
        LimitError: a limit was reached, or Ctrl-C was pressed.
    """
    try:
        with limits:
            yield
    except KeyboardInterrupt:
        limits.seconds, limits.interrupted = 0.0, True
        raise LimitError("interrupt") from None


def check_limits(more_bytes: float = 0) -> None:
    """Raise LimitError if the present limits are reached, or would be with `more_bytes`.

    Without present limits, the limit is the free memory.
    """
    limits = _present.get()
    if limits is not None:
        limits.check(more_bytes)
    elif more_bytes and more_bytes > available_memory():  # last, as it reads a file
        raise LimitError("memory")


def left() -> tuple[float, float]:
    """Return the time, s, and the memory, bytes, that the present limits leave; without any, the free memory."""
    limits = _present.get()
    if limits is None:
        return math.inf, available_memory()
    return limits.seconds_left, limits.bytes - limits.bytes_taken


def clocked(value: T) -> T:
    """Return a value, such as a line of a file, and check the limits once every `CLOCK_PERIOD` calls."""
    if next(_CALLS) % CLOCK_PERIOD == 0:
        check_limits()
    return value


def bounded(path: Path, most: int = MOST_BYTES) -> Path:
    """Return the path of a file to read at once; raise OSError for a device or pipe, or more than `most` bytes."""
    if path.exists() and not (path.is_file() or path.is_dir()):  # reading a folder raises an error by itself
        raise OSError(errno.EINVAL, "no regular file", str(path))
    if path.exists() and path.stat().st_size > most:
        raise OSError(errno.EFBIG, f"larger than {most} bytes", str(path))
    return path


def run_within_limits(run: Callable[[np.ndarray], T], entries: float = math.inf) -> T:
    """Run a kernel that fills or reads some entries; its argument is a flag, (1,) bool, set when it must return.

    With many entries, it runs in a separate thread, so that limits and Ctrl-C can end it.

    Raises:
        LimitError: a limit was reached.
    """
    stop = np.zeros(1, dtype=np.bool_)
    if entries < WATCHED_ENTRIES:
        check_limits()
        return run(stop)
    # Imported here, since few kernels need it and the import takes longer than a small problem.
    from concurrent.futures import ThreadPoolExecutor
    from concurrent.futures import TimeoutError as StillRunningError

    with ThreadPoolExecutor(max_workers=1) as pool:
        result = pool.submit(run, stop)
        try:
            while True:
                try:
                    return result.result(CHECK_PERIOD_S)
                except StillRunningError:
                    check_limits()
        finally:
            stop[0] = True
