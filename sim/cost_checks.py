"""What a logged run cost, checked against its scenario."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal

from prefplan.models.action_costs import ACTION_KINDS, MeasuredCosts
from prefplan.quanta import exact
from prefplan.trace import Label
from sim.log import Log
from sim.recorded_world import RecordedWorld
from sim.verdict import Check


def check_action_costs(log: Log, world: RecordedWorld, trace: Sequence[Label]) -> Check:
    """Check that each action cost what the scenario says.

    Measured costs depend on where the hand goes from and to. From or to a place that the scenario does not have, such
    as where an object fell, an action may cost what any other of its kind does.

    Args:
        log: the log.
        world: its world.
        trace: the propositions at the start and after every action.
    """
    name, hand = "action costs", world.model.start
    table = {(kind, before, after): exact(cost) for kind, before, after, cost in log.about.measured}
    for k, action in enumerate(log.about.actions, 1):
        kind, *arguments = action.action.split()
        if kind not in ACTION_KINDS or not arguments:
            return Check(name, False, f"action {k} `{action.action}` is none that an arm can do")
        goal = arguments[-1] if kind in ("transit", "transport") else hand
        right = _costs(world, table, kind, hand, goal)
        if exact(action.cost) not in right:
            said = f"{right.pop()}" if len(right) == 1 else "what its kind costs"
            return Check(name, False, f"action {k} `{action.action}` costs {said}, not {action.cost}")
        dropped = kind == "transport" and f"holding_{arguments[0]}" not in trace[k]
        hand = "" if dropped else goal
    return Check(name, True, "as in the scenario")


def check_number(name: str, claim: int | float | None, derived: int | float) -> Check:
    """Check a number that is claimed against the one that was derived."""
    if claim is None:
        return Check(name, False, f"nothing is claimed; the frames give {derived}")
    # Preferences with a division are floating-point numbers.
    agree = math.isclose(claim, derived, rel_tol=1e-9)
    return Check(name, agree, f"{derived}" if agree else f"{claim} is claimed, but the frames give {derived}")


def _costs(
    world: RecordedWorld, table: dict[tuple[str, str, str], Decimal], kind: str, hand: str, goal: str
) -> set[Decimal]:
    """Return what an action may cost."""
    costs = world.model.costs
    if not isinstance(costs, MeasuredCosts):
        return {exact(costs[kind])}
    if (kind, hand, goal) in table:
        return {table[kind, hand, goal]}
    return {cost for (other, _, _), cost in table.items() if other == kind}
