from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from prefplan.errors import ModelError
from prefplan.models.transition_system import TransitionSystem
from sim.errors import SimulationError
from sim.execution.executor import Execution, execute
from sim.simulation.rollout import FRAME_RATE, Rollout
from sim.skills.catalogue import SKILLS
from sim.world.scene import Scene, build_scene, initial_state
from sim.world.shapes import CUBE_EDGE_M

COST_OPTIMAL = (
    "transit top, grasp pink, transport pink san, release pink san, grasp pink, transport pink bin1, "
    "release pink bin1, transit left, grasp blue, transport blue san, release blue san, grasp blue, "
    "transport blue bin1, release blue bin1"
).split(", ")


def preference_optimal(parking: str) -> list[str]:
    """Return the plan that does blue first and parks pink somewhere meanwhile."""
    plan = (
        "transit top, grasp pink, transport pink P, release pink P, transit left, grasp blue, transport blue san, "
        "release blue san, grasp blue, transport blue bin1, release blue bin1, transit P, grasp pink, "
        "transport pink san, release pink san, grasp pink, transport pink bin1, release pink bin1"
    )
    actions = plan.replace(" P", f" {parking}").split(", ")
    return [action for action in actions if action != "transit bin1"]  # the hand is there already


PLANS = {"cost": COST_OPTIMAL} | {parking: preference_optimal(parking) for parking in ("table", "bin1", "bin2")}


@pytest.fixture(scope="module")
def system(scene: Scene) -> TransitionSystem:
    return scene.model.transition_system()


def assert_good(rollout: Rollout) -> None:
    assert rollout.completed, rollout.reason
    assert rollout.placement_error < 0.005
    assert rollout.speed_share.max() < 1 and rollout.torque_share.max() < 1
    assert [event for event in rollout.events if event.kind == "contact"] == []
    assert all(step.observed == step.predicted for step in rollout.steps)


@pytest.mark.parametrize("name", PLANS)
def test_both_plans_of_case_study_3_are_carried_out(scene: Scene, system: TransitionSystem, name: str) -> None:
    rollout = execute(scene, PLANS[name], seed=100, system=system)
    assert_good(rollout)
    assert [step.action for step in rollout.steps] == PLANS[name]
    final = rollout.steps[-1].observed
    assert final.place["pink"] == final.place["blue"] == "bin1"
    assert final.marks == {("pink", "sanitized"), ("blue", "sanitized")}


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_perturbed_starts_make_no_difference(scene: Scene, system: TransitionSystem, seed: int) -> None:
    name = ("cost", "table")[seed % 2]
    assert_good(execute(scene, PLANS[name], seed=seed, system=system))


def test_a_rollout_can_be_replayed(scene: Scene) -> None:
    rollout = execute(scene, COST_OPTIMAL[:4])
    frames = len(rollout.times)
    assert rollout.qpos.shape == (frames, scene.mujoco.nq) and rollout.glow.shape == (frames,)
    assert np.allclose(rollout.times, np.arange(frames) / FRAME_RATE, atol=0.0021)
    assert rollout.sim_seconds - rollout.times[-1] < 1 / FRAME_RATE
    assert rollout.steps[0].start == 0 and rollout.steps[-1].end == rollout.sim_seconds
    assert [event.kind for event in rollout.events] == ["grasped", "placed"]
    assert rollout.glow.max() == list(scene.slots).index("san")


def test_seeds_move_the_objects_and_none_leaves_them(scene: Scene) -> None:
    nominal, one, two = (execute(scene, [], seed=seed).qpos[0] for seed in (None, 1, 2))
    assert np.array_equal(nominal, initial_state(scene).qpos)
    assert np.abs(one - nominal).max() > 1e-4 and np.abs(one - two).max() > 1e-4


def test_an_empty_plan_is_completed_at_once(scene: Scene) -> None:
    rollout = execute(scene, [])
    assert rollout.completed and rollout.steps == () and rollout.placement_error == 0


def test_progress_is_told_before_each_action(scene: Scene) -> None:
    told: list[tuple[int, int, str]] = []
    execute(scene, ["transit top", "grasp pink"], on_progress=lambda *what: told.append(what))
    assert told == [(0, 2, "transit top"), (1, 2, "grasp pink")]


def test_a_plan_the_model_does_not_allow_is_refused_before_it_begins(scene: Scene) -> None:
    told: list[str] = []
    with pytest.raises(ModelError, match="'grasp blue' does not exist"):
        execute(scene, ["transit left", "grasp blue"], on_progress=lambda done, total, action: told.append(action))
    assert told == []


def test_a_block_moved_before_the_grasp_stops_the_run(scene: Scene, system: TransitionSystem) -> None:
    run = Execution(scene, initial_state(scene), system=system)
    assert run.step("transit top")
    run.cell.data.joint("pink").qpos[:3] = scene.slots["table"][0].position + [0.0, 0.0, CUBE_EDGE_M / 2]
    assert not run.step("grasp pink")
    rollout = run.rollout()
    assert not rollout.completed
    assert rollout.reason == (
        "after `grasp pink`: expected pink in the hand, but it rests on table (pink is not below the hand)"
    )
    assert rollout.steps[-1].observed.place["pink"] == "table"
    assert rollout.events[-1].kind == "mismatch" and rollout.events[-1].detail["action"] == "grasp pink"


def test_a_block_that_falls_from_the_hand_stops_the_run(scene: Scene, system: TransitionSystem) -> None:
    run = Execution(scene, initial_state(scene), system=system)
    run.step("transit top")
    run.step("grasp pink")
    run.cell.data.joint("pink").qpos[:3] = [0.30, 0.0, 0.0225]
    assert not run.step("transport pink san")
    assert (
        run.reason is not None and "expected pink in the hand, but it lies off every location, at (0.30" in run.reason
    )


def test_a_bystander_pushed_away_stops_the_run(scene: Scene, system: TransitionSystem) -> None:
    run = Execution(scene, initial_state(scene), system=system)
    for action in COST_OPTIMAL[:4]:
        assert run.step(action)
    run.cell.data.joint("green").qpos[:3] = [0.65, -0.1, 0.0225]
    assert not run.step("grasp pink")
    assert run.reason == (
        "after `grasp pink`: expected green on right, but it lies off every location, at (0.65, -0.10, 0.02) m"
    )


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
    rollout = execute(build_scene(replace(scene.model, start="top"), meshes=False), ["grasp pink"])
    assert rollout.completed, rollout.reason
    assert rollout.steps[0].observed.held == "pink"
