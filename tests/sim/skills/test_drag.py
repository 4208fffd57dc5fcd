"""An object between two walls higher than itself is dragged or rolled free before it is grasped."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from forged_logs import run_and_log
from scenario_texts import CORNER
from scipy.spatial.transform import Rotation
from skill_runs import assert_clean

from prefplan import ManipulationModel
from prefplan.scenario.decode import loads
from sim.evidence.certificate import certify
from sim.simulation.workcell import Workcell
from sim.skills import drag
from sim.skills.catalogue import perform
from sim.skills.skill import SkillError
from sim.world.scene import build_scene, initial_state

LOW = (
    CORNER.replace('cup = { start = "desk" }', 'cup = { start = "desk", kind = "box", size = [0.05, 0.05, 0.03] }')
    .replace("at = [0.485,", "at = [0.4875,")
    .replace("-0.185,", "-0.1875,")
)
"""The walls are 2 cm higher than the cup, and 2.5 mm from it."""


def test_a_low_object_in_a_corner_is_drawn_free_and_taken() -> None:
    run, log = run_and_log(loads(LOW), seed=0)
    assert log.about.claims.completed
    drawn = [event.detail for event in run.events if event.kind == "drawn free"]
    assert [detail["object"] for detail in drawn] == ["cup"]
    assert 15 < drawn[0]["distance_mm"] < 60
    assert certify(log).refuted == ()


def test_dragging_ends_with_the_first_stroke_under_which_the_object_slips(monkeypatch: pytest.MonkeyPatch) -> None:
    model, advances = loads(LOW).model, [0.01, 0.006, 0.002, 0.01]
    assert isinstance(model, ManipulationModel)
    scene = build_scene(model)
    cell = Workcell(scene, initial_state(scene))

    def slipping(cell: Workcell, obj: str, *_: object) -> None:
        cell.data.joint(obj).qpos[0] += advances.pop(0)
        mujoco.mj_forward(scene.mujoco, cell.data)

    monkeypatch.setattr(drag, "_stroke", slipping)
    with pytest.raises(SkillError, match="slipped under the fingers"):
        drag.drag_free(cell, "cup", np.array([0.1, 0.0, 0.0]))
    assert advances == [0.01]


def test_a_can_that_lies_in_a_corner_is_rolled_free_set_aside_and_set_upright() -> None:
    can = 'cup = { start = "desk", kind = "cylinder", size = [0.03, 0.06] }'
    model = loads(CORNER.replace('cup = { start = "desk" }', can)).model
    assert isinstance(model, ManipulationModel)
    scene = build_scene(model)
    data = initial_state(scene)
    # Its side touches one wall, its end the other one.
    data.joint("cup").qpos[:3] = 0.444, -0.159, 0.015
    data.joint("cup").qpos[3:] = Rotation.from_euler("y", 90, degrees=True).as_quat(scalar_first=True)
    mujoco.mj_forward(scene.mujoco, data)
    cell = Workcell(scene, data)
    for action in ("transit desk", "grasp cup", "transport cup tray", "release cup tray"):
        perform(cell, action, ahead=["release cup tray"])
    assert [event.kind for event in cell.events] == ["drawn free", "set aside", "grasped", "placed"]
    assert_clean(cell)
    cup = cell.observe("cup")
    assert cup.tilt < np.radians(1) and np.hypot(*(cup.position - scene.slots["tray"][0].position)[:2]) < 0.002
