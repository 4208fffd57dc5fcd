"""When a search stops before its end."""

from __future__ import annotations

import math
import os
import time
from dataclasses import dataclass, field


def available_memory() -> int:
    """Return how many bytes of memory are free, or 2 GiB where that cannot be told."""
    try:
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError):
        return 2**31


@dataclass
class Limits:
    """Bounds of a search's effort, and how far it got.

    Attributes:
        seconds: time, from when this was made.
        bytes: memory of the search.
        ended: `time`, `memory` or `interrupt` once that stopped a search.
        complete_below: all goals of lower cost (internal units) have been found.
    """

    seconds: float = math.inf
    bytes: float = math.inf
    ended: str | None = None
    complete_below: float = 0
    _began: float = field(default_factory=time.perf_counter)

    @property
    def out_of_time(self) -> bool:
        """Whether the time is up."""
        return self.seconds_left < 0

    @property
    def seconds_left(self) -> float:
        """How much of the time is left; negative once it is up."""
        return self.seconds - (time.perf_counter() - self._began)
