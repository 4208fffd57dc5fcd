"""Exit statuses of the programs."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    # The programs import this module before they load anything else.
    from prefplan.front import Reason

DONE, BAD_INPUT, NO_PLAN, FAILED, INTERRUPTED = 0, 2, 3, 4, 130


def no_plan(reason: Reason) -> int:
    """Print on stderr why there is no plan, and return the exit status."""
    print(f"prefplan: {reason}", file=sys.stderr)
    return NO_PLAN
