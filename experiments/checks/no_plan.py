"""The plan that a command is about, or why there is none."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import click

import prefplan as pp
from experiments.cli import output
from experiments.cli.choice import Wanted, choose
from experiments.cli.status import NO_PLAN, tell


def chosen_plan(
    scenario: pp.Scenario, planner: pp.Planner, wanted: Wanted, *, as_json: bool = False, **options: Any
) -> pp.Plan:
    """Return the wanted plan, as `choose` does; if there is none, say why and end the command.

    The reason is printed on stderr, and with `as_json` also as an object on stdout.
    """
    try:
        return choose(planner, wanted, **options)
    except pp.NoPlanError as error:
        if as_json:
            reason = asdict(error.reason)
            found = output.result_json(scenario, planner, complete=True, front=[], plan=None, reason=reason)
            output.print_json(found)
        raise click.exceptions.Exit(no_plan(error.reason, planner)) from None


def no_plan(reason: pp.Reason, planner: pp.Planner | None = None) -> int:
    """Print on stderr why there is no plan, and return the exit status.

    With a planner, also print what the arm cannot do, and the likely mistakes in the planner's problem.
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
