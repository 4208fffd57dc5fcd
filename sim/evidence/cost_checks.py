"""The costs of a logged run's actions, checked against its scenario."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from prefplan.claims import Check
from prefplan.exact_costs import exact, to_number
from prefplan.logic.good_prefix import Label
from prefplan.models.costs import by_name
from prefplan.models.manipulation.action_costs import MeasuredCosts
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.manipulation.slots import location_of, pose
from prefplan.models.manipulation.symbolic import holding
from sim.evidence.action_checks import ANSWERS
from sim.evidence.log import Log, measured_costs
from sim.evidence.replay import RecordedWorld


def check_action_costs(log: Log, world: RecordedWorld, trace: Sequence[Label]) -> Check:
    """Check that each action cost what the scenario says.

    Measured costs depend on the slots between which the hand moves. Until the first mismatch, these follow from the
    actions. After it, the cost between any slots of the action's locations is accepted; from or to a place that is no
    location of the scenario, such as where an object fell, the cost of any action of its kind.
    """
    model, hand, state = world.model, world.model.start, world.model.initial_state
    table = {(kind, before, after): exact(cost) for kind, before, after, cost in measured_costs(model.costs)}
    surprised = min((event.time for event in log.about.events if event.kind in ANSWERS), default=math.inf)
    for k, (action, symbolic) in enumerate(zip(log.about.actions, world.actions, strict=True), 1):
        operator = model.operator(symbolic.kind)
        goal = symbolic.location if operator.travels else hand
        right = _costs(model, table, symbolic.kind, hand, goal)
        after = next((after for other, after in operator.outcomes(model, state) if other == symbolic), None)
        if after is None:
            surprised = -math.inf
        elif action.start < surprised:
            pair = symbolic.kind, *(pose(known.hand, known.hand_slot) for known in (state, after))
            state, right = after, {table[pair]} if pair in table else right
        if exact(action.cost) not in right:
            said = f"{to_number(right.pop())}" if len(right) == 1 else "another amount"
            return Check("action costs", False, f"action {k} `{action.action}` costs {said}, not {action.cost}")
        dropped = operator.travels and symbolic.obj and holding(symbolic.obj) not in trace[k]
        hand = "" if dropped else goal
    return Check("action costs", True, "as in the scenario")


def _costs(
    model: ManipulationModel, table: dict[tuple[str, str, str], Fraction], kind: str, hand: str, goal: str
) -> set[Fraction]:
    """Return the costs that an action of a kind may have between any slots of two locations."""
    if not isinstance(model.costs, MeasuredCosts):
        return {exact(by_name(model.costs[kind])[model.cost_names[0]])}
    between = {
        cost for (other, *ends), cost in table.items() if other == kind and [*map(location_of, ends)] == [hand, goal]
    }
    return between or {cost for (other, _, _), cost in table.items() if other == kind}
