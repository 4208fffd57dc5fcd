"""Why there is no plan."""

from __future__ import annotations

from dataclasses import asdict

import prefplan as pp
from experiments.cli import output
from experiments.cli.status import NO_PLAN, tell


def show_no_plan(scenario: pp.Scenario, planner: pp.Planner, error: pp.NoPlanError, *, as_json: bool) -> int:
    """Print why there is no plan on stderr, as JSON also as an object on stdout; return the exit status."""
    if as_json:
        reason = asdict(error.reason)
        found = output.result_json(scenario, planner, complete=True, front=[], plan=None, reason=reason)
        output.print_json(found)
    return no_plan(error.reason, planner)


def no_plan(reason: pp.Reason, planner: pp.Planner | None = None) -> int:
    """Print on stderr why there is no plan, and return the exit status.

    For a given planner also what the arm cannot do is printed, and the likely mistake in its problem.
    """
    tell(reason)
    if planner is None:
        return NO_PLAN
    if planner.geometry is not None and (note := planner.geometry.note):
        tell(note)
    if reason.kind == "task":
        from experiments.checks.propositions import size_of, uncarried
        from prefplan.limits import Limits

        carried = size_of(planner.problem.system, Limits())["propositions"]
        for i, task in enumerate(planner.problem.tasks):
            for line in uncarried(i, task, carried) if task.name in reason.tasks else ():
                tell(line)
    return NO_PLAN
