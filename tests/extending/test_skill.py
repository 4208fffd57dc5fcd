"""A skill of one's own, from outside: the closed hand pushes an object along the table to another location."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

import prefplan as pp
import sim
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.manipulation.operators import Outcomes
from prefplan.models.manipulation.symbolic import at
from sim.skills.hand import HOVER_HEIGHT_M, move_tool

FINGER_M, STEP_M = 0.012, 0.01
"""Half the width of a finger, and length of one movement while pushing: short ones are slow, and nothing slides on."""


class Push(sim.Skill):
    """Push an object from `near`, below the empty hand, to `far`."""

    kind, travels = "push", True

    def outcomes(self, model: ManipulationModel, state: pp.ManipulationState) -> Outcomes:
        for obj, here in state.places:
            if state.held is None and state.hand == here == "near" and "far" not in state.place.values():
                places = tuple((state.place | {obj: "far"}).items())
                yield pp.Action("push", obj, "far"), replace(state, hand="far", places=places)

    def effect(self, action: pp.Action) -> frozenset[str]:
        return frozenset({at(action.obj, action.location)})

    def perform(self, cell: sim.Workcell, action: pp.Action, ahead: Sequence[pp.Action] = ()) -> None:
        obj, goal = action.obj, cell.scene.slots[action.location][0].position
        centre, half = cell.measure(obj).position, cell.scene.shapes[obj].half
        along = np.array([*(goal - centre)[:2], 0.0]) / np.linalg.norm((goal - centre)[:2])
        goal, yaw = np.array([*goal[:2], centre[2]]), float(np.arctan2(along[1], along[0]) + np.pi / 2)
        behind, up = along * (half[0] + FINGER_M), np.array([0.0, 0.0, HOVER_HEIGHT_M])
        cell.touch(obj)
        cell.grip(0.0, 0.3)
        _, hand = cell.arm.reach(sim.ToolPose.down(centre - 1.3 * behind + up, yaw).symmetric_poses())
        move_tool(cell, hand)
        pushing = np.linspace(centre - 1.3 * behind, goal - behind, round(np.linalg.norm(goal - centre) / STEP_M))
        for position in (*pushing, goal - behind + up, goal + up):
            move_tool(cell, sim.ToolPose(position, hand.rotation))


def test_a_skill_from_outside_is_planned_and_carried_out() -> None:
    locations = pp.Location("near", at=(0.42, 0.0)), pp.Location("far", at=(0.56, 0.0))
    costs = {"transit": 3, "grasp": 1, "transport": 5, "release": 1, "push": 4}
    model = pp.ManipulationModel(
        "home", costs, locations, (pp.Object("cup", "near"),), operators=(*sim.SKILLS.values(), Push())
    )
    plan = pp.cheapest_plan(pp.Problem(model.transition_system(), [pp.Task("tidy", "F cup_far")], pp.Order()))
    assert (plan.actions, plan.cost) == (("transit near", "push cup far"), 7)
    rollout = sim.execute(sim.build_scene(model), plan.actions, skills={**sim.SKILLS, "push": Push()})
    assert rollout.completed, rollout.reason
    assert [event for event in rollout.events if event.kind == "contact"] == [], "the fingers may touch the cup"
    assert rollout.steps[-1].observed.place == {"cup": "far"} == rollout.steps[-1].predicted.place
    assert 0 < rollout.placement_error < 0.01
