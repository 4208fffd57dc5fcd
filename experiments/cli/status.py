"""Exit statuses of the programs."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    # The programs import this module before they load anything else.
    from prefplan.front import Reason
    from prefplan.problem import Problem

DONE, BAD_INPUT, NO_PLAN, FAILED, INTERRUPTED = 0, 2, 3, 4, 130


def no_plan(reason: Reason, problem: Problem | None = None) -> int:
    """Print on stderr why there is no plan, for a given problem also the likely mistake, and return the exit status."""
    print(f"prefplan: {reason}", file=sys.stderr, flush=True)
    if problem is not None and reason.kind == "task":
        from experiments.cli.propositions import size_of, uncarried
        from prefplan.limits import Limits

        carried = size_of(problem.system, Limits())["propositions"]
        for i, task in enumerate(problem.tasks):
            for line in uncarried(i, task, carried) if task.name in reason.tasks else ():
                print(f"prefplan: {line}", file=sys.stderr)
    return NO_PLAN
