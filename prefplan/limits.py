"""When planning may stop: limits of time and memory for all that is done under them, and how near is near enough."""

from __future__ import annotations

import math
import os
import resource
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures import TimeoutError as StillRunningError
from contextlib import contextmanager
from contextvars import ContextVar, Token
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, TypeVar

import numpy as np

from prefplan.errors import LimitError, PrefplanError
from prefplan.exact_costs import Number, exact

T = TypeVar("T")

CHECK_PERIOD_S = 0.05
"""Time between two checks of the limits while a kernel runs."""

MEMORY_SHARE = 0.8
"""Part of the free memory that planning may take unless told otherwise."""

NO_INFLATION = 2**60
"""Divisor that leaves nothing of any bound of cost: larger than all of them."""

FIRST_ROUND, ROUND_FACTOR = 100, 10
"""Before a front within some percent come coarser ones: the largest percentage, and the factor from one to the next."""


def available_memory() -> int:
    """Return how many bytes of memory are free, or 2 GiB where that is not known."""
    try:
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError):
        return 2**31


def memory_in_use() -> int:
    """Return how many bytes of memory this process takes; the most it ever took where only that is known."""
    try:
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


@dataclass
class Limits:
    """Bounds of an effort, and how far it got; as a context, `check_limits` keeps to them.

    Those that are made in the context of others end no later, and leave no more memory.

    Attributes:
        seconds: time, from when this was made.
        bytes: memory, beyond what was in use when this was made.
        ended: `time`, `memory` or `interrupt` once that stopped a search.
        complete_below: all goals of lower cost (internal units) have been found.
    """

    seconds: float = math.inf
    bytes: float = math.inf
    ended: str | None = None
    complete_below: float = 0
    _began: float = field(default_factory=time.perf_counter)
    _in_use_before: int = field(default_factory=memory_in_use)
    _outer: Token[Limits | None] | None = None

    def __post_init__(self) -> None:
        """Keep to the present limits too."""
        outer = _present.get()
        if outer is not None:
            self.seconds = min(self.seconds, outer.seconds_left + time.perf_counter() - self._began)
            if outer.bytes < math.inf:
                self.bytes = min(self.bytes, outer.bytes - outer.bytes_taken + self.bytes_taken)

    @property
    def out_of_time(self) -> bool:
        """Whether the time is up."""
        return self.seconds_left < 0

    @property
    def seconds_left(self) -> float:
        """How much of the time is left; negative once it is up."""
        return self.seconds - (time.perf_counter() - self._began)

    @property
    def bytes_taken(self) -> int:
        """Memory that was taken since this was made."""
        return memory_in_use() - self._in_use_before

    def check(self, more_bytes: float = 0) -> None:
        """Raise LimitError if the time is up, or if the memory does not hold so much more."""
        if self.out_of_time:
            raise LimitError("time")
        if self.bytes < math.inf and self.bytes_taken + more_bytes > self.bytes:
            raise LimitError("memory")

    def __enter__(self) -> Limits:
        """Make these the present limits."""
        self._outer = _present.set(self)
        return self

    def __exit__(self, *error: object) -> None:
        """Return to the limits that were present before."""
        if self._outer is not None:
            _present.reset(self._outer)


_present: ContextVar[Limits | None] = ContextVar("limits", default=None)


@contextmanager
def interruptible(limits: Limits) -> Iterator[None]:
    """Work within limits that Ctrl-C reaches too: no time is left of them then.

    Raises:
        LimitError: a limit was reached, or Ctrl-C was pressed.
    """
    try:
        with limits:
            yield
    except KeyboardInterrupt:
        limits.seconds, limits.ended = 0.0, "interrupt"
        raise LimitError("interrupt") from None


def check_limits(more_bytes: float = 0) -> None:
    """Raise LimitError if the present limits are reached, or would be with so much more memory.

    Without present limits, memory that is free is the limit.
    """
    limits = _present.get()
    if limits is not None:
        limits.check(more_bytes)
    elif more_bytes > available_memory():
        raise LimitError("memory")


def run_within_limits(run: Callable[[np.ndarray], T]) -> T:
    """Run a kernel in a thread of its own, so that the present limits and Ctrl-C can stop it.

    Args:
        run: calls the kernel; the flag it is given, (1,) bool, is set once the kernel is to return.

    Raises:
        LimitError: a limit was reached.
    """
    stop = np.zeros(1, dtype=np.bool_)
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


@dataclass(frozen=True)
class Percent:
    """How much worse a plan may be, in percent, than one that it approximates."""

    value: Fraction

    def least(self, value: Any) -> Any:
        """Return the smallest value that another one exceeds by no more than this; the other one itself for 0 %."""
        return Fraction(value) / self.factor if self.value else value

    def least_cost(self, cost: int) -> int:
        """Return the smallest whole cost that another one exceeds by no more than this."""
        return math.ceil(cost / self.factor)

    @property
    def factor(self) -> Fraction:
        """How many times as large a value may be."""
        return 1 + self.value / 100

    @property
    def inflation(self) -> int:
        """The smallest divisor that leaves at most this percentage of anything."""
        return math.ceil(100 / self.value) if self.value else NO_INFLATION

    @property
    def rounds(self) -> list[Percent]:
        """Larger ones, then this."""
        if not self.value:
            return [self]
        found = [self.value]
        while found[-1] * ROUND_FACTOR <= FIRST_ROUND:
            found.append(found[-1] * ROUND_FACTOR)
        return [Percent(value) for value in reversed(found)]


EXACT = Percent(Fraction(0))


def percent(value: Number) -> Percent:
    """Return a number of percent, which must not be negative."""
    number = Fraction(exact(value, "within"))
    if number < 0:
        raise PrefplanError(f"within: {value} is negative; it is a number of percent, 0 for the exact front")
    return Percent(number)
