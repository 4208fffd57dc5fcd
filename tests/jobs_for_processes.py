"""A batch for tests of processes, in a module that a new process loads at once."""

from __future__ import annotations

import os
import signal
from dataclasses import dataclass
from pathlib import Path
from typing import Any

DEADLY, DEADLY_ONCE = 3, 6


@dataclass(frozen=True)
class Jobs:
    """Jobs of which one kills its process each time and one the first time only."""

    once: Path

    key = "job"

    def record(self, number: int) -> dict[str, Any]:
        """Return the number, or end."""
        if number == DEADLY or (number == DEADLY_ONCE and not self.once.exists()):
            if number == DEADLY_ONCE:
                self.once.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return {"job": number, "completed": True}

    def crashed(self, number: int, reason: str) -> dict[str, Any]:
        """Return the record of a job without a result."""
        return {"job": number, "completed": False, "reason": reason}
