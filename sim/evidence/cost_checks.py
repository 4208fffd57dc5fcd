"""The costs of a logged run's actions, checked against its scenario."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from prefplan.claims import Check
from prefplan.exact_costs import exact, to_number
from prefplan.logic.good_prefix import Label
from prefplan.models.costs import amount
from prefplan.models.manipulation.action_costs import MeasuredCosts, cost_names
from prefplan.models.manipulation.model import ManipulationModel, ManipulationState
from prefplan.models.manipulation.slots import location_of, pose
from prefplan.models.manipulation.symbolic import Action, holding
from sim.evidence.log import Log
from sim.evidence.replay import RecordedWorld

SURPRISES = ("retry", "replan", "unaffected")
"""Kinds of events after which a run continues from observed positions."""


def check_action_costs(log: Log, world: RecordedWorld, trace: Sequence[Label]) -> Check:
    """Check that each action cost what the scenario says.

    Measured costs depend on the slots between which the hand moves. Until the first mismatch, these follow from the
    actions. After it, the cost between any slots of the action's locations is accepted; from or to a place that is no
    location of the scenario, such as where an object fell, the cost of any action of its kind.
    """
    name, hand = "action costs", world.model.start
    state: ManipulationState | None = world.model.initial_state
    table = {(kind, before, after): exact(cost) for kind, before, after, cost in world.measured}
    surprised = min((event.time for event in log.about.events if event.kind in SURPRISES), default=math.inf)
    for k, action in enumerate(log.about.actions, 1):
        symbolic = world.action(action.action)
        if symbolic is None:
            return Check(name, False, f"action {k} `{action.action}` is unknown")
        travels = world.model.operator(symbolic.kind).travels
        goal = symbolic.location if travels else hand
        right = _costs(world, table, symbolic.kind, hand, goal)
        before, state = state, _outcome(world.model, state, symbolic)
        if before and state and action.start < surprised:
            pair = symbolic.kind, *(pose(known.hand, known.hand_slot) for known in (before, state))
            right = {table[pair]} if pair in table else right
        if exact(action.cost) not in right:
            said = f"{to_number(right.pop())}" if len(right) == 1 else "another amount"
            return Check(name, False, f"action {k} `{action.action}` costs {said}, not {action.cost}")
        dropped = travels and symbolic.obj and holding(symbolic.obj) not in trace[k]
        hand = "" if dropped else goal
    return Check(name, True, "as in the scenario")


def _outcome(model: ManipulationModel, state: ManipulationState | None, action: Action) -> ManipulationState | None:
    """Return the state to which an action leads in the model; None if the action is not applicable."""
    outcomes = model.operator(action.kind).outcomes(model, state) if state else ()
    return next((after for other, after in outcomes if other == action), None)


def _costs(
    world: RecordedWorld, table: dict[tuple[str, str, str], Fraction], kind: str, hand: str, goal: str
) -> set[Fraction]:
    costs = world.model.costs
    if not isinstance(costs, MeasuredCosts):
        return {exact(amount(costs[kind], cost_names(costs)[0]))}
    between = {
        cost for (other, *ends), cost in table.items() if other == kind and [*map(location_of, ends)] == [hand, goal]
    }
    return between or {cost for (other, _, _), cost in table.items() if other == kind}
