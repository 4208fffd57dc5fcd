from __future__ import annotations

from dataclasses import replace

import pytest

from prefplan.models.action_costs import MeasuredCosts, Pair
from prefplan.models.manipulation import Location, ManipulationModel, ManipulationState, Object
from prefplan.models.measurements import Measurement
from sim import measurement
from sim.effort import Effort
from sim.execution import execute
from sim.measurement import Failure, Trial, measure, measure_all, simulate, trials
from sim.scene import Scene
from sim.skills import SkillError


@pytest.fixture(scope="module")
def wanted(arch_model: ManipulationModel) -> dict[Pair, tuple[Trial, ...]]:
    return trials(arch_model)


def test_everything_a_plan_may_do_is_measured_and_nothing_else(
    arch_model: ManipulationModel, wanted: dict[Pair, tuple[Trial, ...]]
) -> None:
    complete = replace(arch_model, costs=MeasuredCosts("energy", dict.fromkeys(wanted, 1)))
    assert complete.transition_system().size == arch_model.transition_system().size
    assert ("transit", "home", "san") in wanted and ("transit", "san", "home") not in wanted
    # Nothing can be left under what lies on top of it.
    assert ("transport", "left", "top") not in wanted and ("transport", "san", "top") in wanted


def test_each_object_and_remote_states_have_their_turn(wanted: dict[Pair, tuple[Trial, ...]]) -> None:
    samples = wanted["transport", "san", "bin1"]
    assert {trial.action for trial in samples} == {f"transport {thing} bin1" for thing in ("blue", "pink", "green")}
    assert all(trial.state.hand == "san" and trial.state.held == trial.action.split()[1] for trial in samples)
    nearby, remote = samples[0].state, samples[-1].state
    assert len(nearby.marks) < len(remote.marks)


def test_a_simulated_action_takes_what_it_takes_in_an_execution(scene: Scene) -> None:
    actions = ["transit top", "grasp pink", "transport pink san"]
    *_, step = execute(scene, actions).steps
    effort = simulate(scene, Trial(replace(step.predicted, hand="top"), "transport pink san"))
    assert effort.energy == pytest.approx(step.effort.energy, rel=0.02)
    assert effort.time == pytest.approx(step.effort.time, abs=0.02)


def test_what_is_grasped_lies_in_the_slot_that_others_leave(scene: Scene) -> None:
    both = ManipulationState("bin1", "blue", (("pink", "bin1"), ("green", "right")))
    assert simulate(scene, Trial(both, "release blue bin1")).time > 1


def fail_for(thing: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every simulation with an object in the hand fail, and others take a second."""

    def stand_in(scene: Scene, trial: Trial) -> Effort:
        if trial.state.held == thing:
            raise SkillError(f"{thing} is slippery")
        return Effort(1.0, 2.0, 3.0)

    monkeypatch.setattr(measurement, "simulate", stand_in)


def test_the_simulations_that_work_out_count(
    scene: Scene, wanted: dict[Pair, tuple[Trial, ...]], monkeypatch: pytest.MonkeyPatch
) -> None:
    pair: Pair = ("transport", "san", "bin1")
    fail_for("pink", monkeypatch)
    one = measure(scene, pair, wanted[pair])
    assert one == Measurement(pair, {"time": 1.0, "travel": 2.0, "energy": 3.0}, 2)


def test_an_action_that_never_works_out_is_told(
    scene: Scene, wanted: dict[Pair, tuple[Trial, ...]], monkeypatch: pytest.MonkeyPatch
) -> None:
    fail_for("pink", monkeypatch)
    pairs: list[Pair] = [("transport", "san", "bin1"), ("transit", "san", "left")]
    some = {pair: tuple(trial for trial in wanted[pair] if "blue" not in trial.action) for pair in pairs}
    some[pairs[0]] = tuple(trial for trial in some[pairs[0]] if "pink" in trial.action)
    failure, one = measure_all(scene, some)
    assert isinstance(failure, Failure) and failure.pair == pairs[0]
    assert "`transport pink bin1` with hand at san, holding pink" in failure.reason
    assert failure.reason.endswith(": pink is slippery")
    assert isinstance(one, Measurement) and one.pair == pairs[1]


def test_a_start_over_a_location_is_a_location(arch_model: ManipulationModel) -> None:
    model = ManipulationModel("a", arch_model.costs, (Location("a", at=(0.5, 0)), Location("b", at=(0.5, 0.2))), ())
    assert list(trials(model)) == [("transit", "a", "b"), ("transit", "b", "a")]
    one = replace(model, objects=(Object("cup", "b"),))
    assert ("grasp", "a", "a") in trials(one)
