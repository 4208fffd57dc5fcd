"""The plan that options choose: `--plan cost|preference|INDEX` within bounds and limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import click
from click.core import ParameterSource

import prefplan as pp
from prefplan.errors import choices

if TYPE_CHECKING:
    from prefplan.exact_costs import Number

FOR_ARMS = ("plans", "seed", "robot")
"""Parameters, of commands for all models, that only an arm uses; the options of videos are not among them."""


class Wanted(NamedTuple):
    """The plan that `--plan` names: an objective, `cost`, `preference` or an index of the front, within bounds."""

    plan: str | int = "cost"
    max_preference: Number | None = None
    max_cost: Number | None = None

    @property
    def continuation(self) -> str | int:
        """Which plan a run follows after a mismatch, see `experiments.runs.run_plan.Conditions.choice`."""
        return "bounded" if self.plan == "cost" and self.max_preference is not None else self.plan


def choose(
    planner: pp.Planner,
    wanted: Wanted,
    *,
    at_most: Mapping[str, Number] | None = None,
    keep_on_interrupt: bool = False,
) -> pp.Plan:
    """Return the wanted plan; `at_most` bounds other objectives, and with `keep_on_interrupt` Ctrl-C counts as a limit.

    Raises:
        NoPlanError: there is none at all.
        UnfinishedError: a limit ended the search first; its `best` is the best plan known by then, or for an index the
            known plan that is nearest to it.
        PreferenceError: a bound on the cost is needed.
        PrefplanError: the front within the bounds has no plan of that index.
    """
    index, max_preference, max_cost = wanted
    bounds = bounds_of(planner.problem, at_most or {}, max_preference)
    limits: pp.FrontLimits = {"max_cost": max_cost, "at_most": bounds}
    if isinstance(index, str):
        name = objective_name(planner.problem, index, "--objective")
        return planner.best(name, keep_on_interrupt=keep_on_interrupt, **limits)
    front = planner.front(keep_on_interrupt=keep_on_interrupt, **limits)
    if front.reason:
        raise pp.NoPlanError(front.reason)
    if front.ended:
        nearest = front[min(index, len(front) - 1)] if front else None
        below = front.complete_below
        if nearest is None or index >= len(front) or below is None or nearest.cost >= below:
            raise pp.UnfinishedError(front.ended, complete_below=below, best=nearest)
    return plan_at(front, index, "--plan")


def objective_name(problem: pp.Problem, name: str, option: str) -> str:
    """Return the name of an objective, or raise PrefplanError that names the option.

    `cost` stands for the first cost, and `preference` for the first preference.
    """
    names = problem.objective_names
    if name in names:
        return name
    if name == "cost":
        return names[0]
    if name == "preference" and problem.preferences:
        return problem.preferences[0].name
    raise pp.PrefplanError(f"{option}: unknown objective {name!r} {choices(name, names)}")


def bounds_of(
    problem: pp.Problem, at_most: Mapping[str, Number], max_preference: Number | None = None
) -> Mapping[str, Number]:
    """Return the bounds of `--at-most` and `--max-preference` by objective; of two bounds on one, the lesser.

    Raises:
        PrefplanError: the problem has no such objective.
    """
    given = [(objective_name(problem, name, "--at-most"), bound) for name, bound in at_most.items()]
    if max_preference is not None:
        if not problem.preferences:
            raise pp.PrefplanError(f"--max-preference: there is no preference {choices('', problem.objective_names)}")
        given.append((problem.preferences[0].name, max_preference))
    return {name: min(bound for other, bound in given if other == name) for name, _ in given}


def check_arm_options(scenario: pp.Scenario) -> None:
    """Raise PrefplanError if this command was given an option that only an arm uses, and the model has no arm."""
    if isinstance(scenario.model, pp.ManipulationModel):
        return
    context = click.get_current_context()
    for option in context.command.params:
        if option.name in FOR_ARMS and context.get_parameter_source(option.name) is ParameterSource.COMMANDLINE:
            kind = f"{scenario.path} has a {scenario.model.kind} model"
            raise pp.PrefplanError(f"{option.opts[-1]}: only for the arm of a manipulation model, and {kind}")


def plan_at(front: pp.Front, index: int, option: str) -> pp.Plan:
    """Return a plan of a front, or raise PrefplanError that names the option if there is none of that index."""
    if index >= len(front):
        valid = "one plan, 0" if len(front) == 1 else f"plans 0 to {len(front) - 1}" if front else "no plans"
        raise pp.PrefplanError(f"{option} {index}: the front has {valid}")
    return front[index]
