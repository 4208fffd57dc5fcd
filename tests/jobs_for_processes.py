"""A job for tests of processes, in a module that a new process loads at once."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import Any

HANGS, CRASHES = 1, 2


def report_and_end(number: int, tell: Callable[[dict[str, Any]], None]) -> dict[str, Any]:
    """Report a number, then hang, crash or return it again."""
    tell({"told": number})
    if number == HANGS:
        time.sleep(600)
    if number == CRASHES:
        os.abort()
    return {"done": number}
