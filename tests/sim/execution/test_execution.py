from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from skill_runs import assert_good

from prefplan.errors import ModelError
from prefplan.models.manipulation.symbolic import Action
from prefplan.models.transition_system import TransitionSystem
from sim.errors import SimulationError
from sim.execution.executor import Execution, execute
from sim.perception.sensors import ExactSensor, ObjectPose
from sim.robots.robot import Robot
from sim.simulation.run import FRAME_RATE_HZ, Event
from sim.simulation.workcell import BLEND_TIME_S, Workcell
from sim.skills.catalogue import SKILLS
from sim.skills.release import ReleaseSkill
from sim.skills.skill import SkillError
from sim.world.scene import Scene, build_scene, initial_state

REST_SPEED_RAD_S = 0.02
"""The arm rests while every joint is slower than this (at 0.5 m that is 1 cm/s)."""

COST_OPTIMAL = (
    "transit top, grasp pink, transport pink san, release pink san, grasp pink, transport pink bin1, "
    "release pink bin1, transit left, grasp blue, transport blue san, release blue san, grasp blue, "
    "transport blue bin1, release blue bin1"
).split(", ")


PREFERENCE_OPTIMAL = (
    "transit top, grasp pink, transport pink bin1, release pink bin1, transit left, grasp blue, transport blue san, "
    "release blue san, grasp blue, transport blue bin1, release blue bin1, grasp pink, transport pink san, "
    "release pink san, grasp pink, transport pink bin1, release pink bin1"
).split(", ")
"""Blue is done first, and pink is parked meanwhile."""


@pytest.fixture(scope="module")
def system(scene: Scene) -> TransitionSystem:
    return scene.model.transition_system()


@pytest.mark.parametrize(("plan", "seed"), [(COST_OPTIMAL, 0), (PREFERENCE_OPTIMAL, 5)], ids=["cost", "preference"])
def test_plans_of_case_study_3_are_carried_out_from_perturbed_starts(
    scene: Scene, system: TransitionSystem, plan: list[str], seed: int
) -> None:
    rollout = execute(scene, plan, seed=seed, system=system)
    assert_good(rollout)
    rest_share = (rollout.loads["speeds"][1:] < REST_SPEED_RAD_S).all(axis=1).mean()
    assert 0.05 < rest_share < 0.15, "it rests to close and to open the hand"
    assert [step.action for step in rollout.steps] == plan
    final = rollout.steps[-1].observed
    assert final.place["pink"] == final.place["blue"] == "bin1"
    assert final.marks == {("pink", "sanitized"), ("blue", "sanitized")}


def test_a_rollout_can_be_replayed_and_progress_is_told_before_each_action(scene: Scene) -> None:
    told: list[tuple[int, int, str]] = []
    rollout = execute(scene, COST_OPTIMAL[:4], on_progress=lambda *what: told.append(what))
    assert told == [(k, 4, action) for k, action in enumerate(COST_OPTIMAL[:4])]
    frames = len(rollout.times)
    assert rollout.qpos.shape == (frames, scene.mujoco.nq) and rollout.glow.shape == (frames,)
    assert np.allclose(rollout.times, np.arange(frames) / FRAME_RATE_HZ, atol=0.0021)
    assert rollout.sim_seconds - rollout.times[-1] < 1 / FRAME_RATE_HZ
    assert rollout.steps[0].start == 0
    assert 0 <= rollout.sim_seconds - rollout.steps[-1].end <= BLEND_TIME_S + 0.01, "the arm comes to rest at last"
    assert [event.kind for event in rollout.events] == ["grasped", "placed"]
    assert rollout.glow.max() == list(scene.slots).index("san")


@pytest.mark.parametrize(
    ("before", "obj", "excused"),
    [(1.0, "green", True), (1.0, "blue", False), (3.0, "green", False), (-1.0, "green", False)],
)
def test_an_unwanted_touch_counts_unless_a_fault_has_just_moved_the_object(
    scene: Scene, system: TransitionSystem, before: float, obj: str, excused: bool
) -> None:
    run = Execution(scene, initial_state(scene), system=system)
    touch = Event(5.0, "contact", {"moving": "hand", "other": "green"})
    fault = Event(5.0 - before, "fault", {"fault": f"knock:{obj}@1", "object": obj})
    run.cell.events += sorted([fault, touch], key=lambda event: event.time)
    rollout = run.record()
    assert rollout.completed == excused and rollout.reason == (None if excused else "hand touched green at 5.00 s")


def test_a_run_that_exceeded_a_limit_does_not_say_that_it_was_completed(
    scene: Scene, system: TransitionSystem, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = Execution(scene, initial_state(scene), system=system)
    assert run.step("transit top")
    fastest = run.record().load_shares["speeds"]
    assert run.record().completed and fastest.max() < 1
    limits = run.scene.robot.load_limits | {"speeds": run.scene.robot.load_limits["speeds"] * fastest / 1.25}
    monkeypatch.setattr(Robot, "load_limits", limits)
    rollout = run.record()
    assert not rollout.completed and re.fullmatch(
        r"joint\d exceeded a limit: 125.0% of its speeds", str(rollout.reason)
    )


def test_an_empty_plan_is_completed_at_once_from_where_the_seed_puts_the_objects(scene: Scene) -> None:
    rollouts = [execute(scene, [], seed=seed) for seed in (None, 1, 1, 2)]
    assert all(rollout.completed and rollout.steps == () and rollout.placement_error == 0 for rollout in rollouts)
    nominal, one, again, two = (rollout.qpos[0] for rollout in rollouts)
    assert np.array_equal(nominal, initial_state(scene).qpos) and np.array_equal(one, again)
    assert np.abs(one - nominal).max() > 1e-4 and np.abs(one - two).max() > 1e-4


def test_a_plan_the_model_does_not_allow_is_refused_before_it_begins(scene: Scene) -> None:
    told: list[str] = []
    with pytest.raises(ModelError, match="'grasp blue' does not exist"):
        execute(scene, ["transit left", "grasp blue"], on_progress=lambda done, total, action: told.append(action))
    assert told == []


@pytest.mark.parametrize(
    ("done", "obj", "point", "action", "reason"),
    [
        pytest.param(
            1,
            "pink",
            (0.62, 0.20, 0.0225),
            "grasp pink",
            "after `grasp pink`: expected pink in the hand, but it rests on table (pink is not below the hand)",
            id="moved before the grasp",
        ),
        pytest.param(
            2,
            "pink",
            (0.30, 0.0, 0.0225),
            "transport pink san",
            "expected pink in the hand, but it lies off every location, at (0.30",
            id="fallen from the hand",
        ),
        pytest.param(
            4,
            "green",
            (0.65, -0.1, 0.0225),
            "grasp pink",
            "after `grasp pink`: expected green on right, but it lies off every location, at (0.65, -0.10, 0.02) m",
            id="a bystander pushed away",
        ),
    ],
)
def test_an_object_that_is_not_where_it_should_be_stops_the_run(
    scene: Scene, system: TransitionSystem, done: int, obj: str, point: tuple[float, ...], action: str, reason: str
) -> None:
    run = Execution(scene, initial_state(scene), system=system)
    assert all(run.step(before) for before in COST_OPTIMAL[:done])
    run.cell.data.joint(obj).qpos[:3] = point
    assert not run.step(action)
    rollout = run.record()
    assert not rollout.completed and reason in str(rollout.reason)
    assert rollout.events[-1].kind == "mismatch" and rollout.events[-1].detail["action"] == action


@pytest.mark.parametrize("at_rest", [False, True])
def test_what_moves_after_an_action_was_confirmed_is_a_mismatch_of_that_action(
    scene: Scene, system: TransitionSystem, at_rest: bool
) -> None:
    """Else a certificate finds that the action failed, and no event that says so."""
    run = Execution(scene, initial_state(scene), system=system)
    assert run.step("transit top") and run.check_state(at_rest=at_rest)
    assert run.cell.events == []
    run.cell.data.joint("green").qpos[:3] = [0.65, -0.1, 0.0225]
    assert not run.check_state(at_rest=at_rest)
    (event,) = run.cell.events
    assert event.kind == "mismatch" and event.detail == {"action": "transit top", "reason": run.reason}


class SwayingSensor(ExactSensor):
    """Observes every object a centimetre to and fro, several times a second."""

    def observe(self, scene: Scene, data: mujoco.MjData, obj: str) -> ObjectPose | None:
        true = super().observe(scene, data, obj)
        sway = 0.01 * np.sin(9.0 * data.time)
        return true and replace(true, position=true.position + [sway, 0.0, 0.0])


def test_what_does_not_come_to_rest_is_no_final_state(scene: Scene, system: TransitionSystem) -> None:
    run = Execution(scene, initial_state(scene), system=system, sensor=SwayingSensor())
    assert not run.check_state(at_rest=True)
    assert str(run.reason).endswith(" does not come to rest")


class BreakingRelease(ReleaseSkill):
    """Puts an object down, and then says that it failed."""

    def perform(self, cell: Workcell, action: Action, ahead: Sequence[Action] = ()) -> None:
        super().perform(cell, action, ahead)
        raise SkillError("broken")


def test_no_mark_is_given_by_a_release_that_failed(scene: Scene, system: TransitionSystem) -> None:
    run = Execution(scene, initial_state(scene), system=system, skills=SKILLS | {"release": BreakingRelease()})
    for action in COST_OPTIMAL[:3]:
        assert run.step(action)
    assert not run.step("release pink san")
    observed = run.steps[-1].observed
    assert (observed.place["pink"], observed.marks) == ("san", frozenset())


def test_no_mark_is_given_where_nothing_was_put_down(scene: Scene, system: TransitionSystem) -> None:
    run = Execution(scene, initial_state(scene), system=system)
    for action in COST_OPTIMAL[:3]:
        assert run.step(action)
    run.cell.data.joint("pink").qpos[:3] = [0.30, 0.0, 0.0225]
    assert not run.step("release pink san")
    assert run.steps[-1].observed.marks == frozenset()


def test_a_kind_of_action_without_a_skill_is_refused(scene: Scene, system: TransitionSystem) -> None:
    skills = {kind: skill for kind, skill in SKILLS.items() if kind != "grasp"}
    with pytest.raises(SimulationError, match=r"skills: none for 'grasp' \(valid: transit, transport, release\)"):
        Execution(scene, initial_state(scene), system=system, skills=skills)


def test_a_hand_that_starts_over_a_location_is_brought_there(scene: Scene) -> None:
    rollout = execute(build_scene(replace(scene.model, start="top")), ["grasp pink"])
    assert rollout.completed, rollout.reason
    assert rollout.steps[0].observed.held == "pink"
