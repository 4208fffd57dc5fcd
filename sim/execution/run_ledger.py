"""The ledger of a run: what its actions have cost, and which tasks its observations satisfy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

from prefplan.ledger import Ledger
from prefplan.models.manipulation.model import ManipulationState
from prefplan.plan import Plan
from prefplan.problem import Problem
from sim.simulation.run import Step


def ledger_of(problem: Problem, plan: Plan, steps: Sequence[Step]) -> Ledger:
    """Return the ledger of the actions that were carried out, from the observation after each of them.

    The plan's first state is the first observed one; the plan's relaxations are applied to the observations.
    """
    start = cast(ManipulationState, plan.states[0])
    return Ledger.of(
        problem,
        [step.action for step in steps],
        [step.cost for step in steps],
        [start.label, *(step.observed.label for step in steps)],
        plan.relaxations,
    )
