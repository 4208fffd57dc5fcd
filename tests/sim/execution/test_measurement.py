from __future__ import annotations

import ast
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest

import sim
from prefplan.models.manipulation.action_costs import MeasuredCosts, Pair
from prefplan.models.manipulation.measured_costs import Measurement
from prefplan.models.manipulation.model import Location, ManipulationModel, ManipulationState, Object
from prefplan.models.manipulation.slots import free_slot
from prefplan.models.manipulation.surroundings import Fixture
from sim.capability import sources
from sim.capability.sources import FOLDERS, digest_of_sources
from sim.execution import cost_measurement
from sim.execution.cost_measurement import Failure, Trial, measure, measure_all, simulate, trials
from sim.execution.executor import execute
from sim.perception.grounding import slot_of
from sim.perception.sensors import true_poses
from sim.simulation.run import Effort
from sim.simulation.workcell import Workcell
from sim.skills.catalogue import perform
from sim.skills.skill import SkillError
from sim.world.scene import Scene, build_scene, initial_state


@pytest.fixture(scope="module")
def wanted(arch_model: ManipulationModel) -> dict[Pair, tuple[Trial, ...]]:
    return trials(arch_model)


def test_everything_a_plan_may_do_is_measured_and_nothing_else(
    arch_model: ManipulationModel, wanted: dict[Pair, tuple[Trial, ...]]
) -> None:
    complete = replace(arch_model, costs=MeasuredCosts("energy", dict.fromkeys(wanted, 1)))
    assert places_of(complete) == places_of(arch_model)
    assert ("transit", "home", "san") in wanted and ("transit", "san", "home") not in wanted
    # Nothing can be left under what lies on top of it.
    assert ("transport", "left", "top") not in wanted and ("transport", "san", "top") in wanted


def places_of(model: ManipulationModel) -> set[Any]:
    """Return the states of a model, wherever in its locations the objects lie."""
    states = cast(Iterable[ManipulationState], model.transition_system().listed.states)
    return {(state.hand, state.held, state.places, state.marks) for state in states}


def test_slots_are_measured_apart(wanted: dict[Pair, tuple[Trial, ...]]) -> None:
    into = {after for kind, before, after in wanted if (kind, before) == ("transport", "san")}
    assert into == {"top", "left", "right", "bin1[0]", "bin1[1]", "bin2[0]", "bin2[1]", "table"}
    assert {after for kind, before, after in wanted if (kind, before) == ("grasp", "bin1")} == {"bin1[0]", "bin1[1]"}
    second = wanted["release", "bin1[1]", "bin1[1]"]
    assert all(0 in dict(trial.state.slots).values() for trial in second)


def test_the_hand_rises_from_what_it_has_just_put_down(wanted: dict[Pair, tuple[Trial, ...]]) -> None:
    samples = wanted["transit", "bin1[1]", "san"]
    assert all(trial.put and dict(trial.state.slots)[trial.put] == 1 for trial in samples)
    assert all(trial.put and trial.state.place[trial.put] == "table" for trial in wanted["transit", "table", "san"])
    assert not any(trial.put for trial in (*wanted["transit", "home", "san"], *wanted["grasp", "table", "table"]))


def test_each_object_and_remote_states_have_their_turn(wanted: dict[Pair, tuple[Trial, ...]]) -> None:
    samples = wanted["transport", "san", "bin1[0]"]
    assert {trial.action for trial in samples} == {f"transport {obj} bin1" for obj in ("blue", "pink", "green")}
    assert all(trial.state.hand == "san" and trial.state.held == trial.action.split()[1] for trial in samples)
    nearby, remote = samples[0].state, samples[-1].state
    assert len(nearby.marks) < len(remote.marks)


def test_the_actions_of_a_large_model_are_found_without_listing_all_states(
    arch_model: ManipulationModel, wanted: dict[Pair, tuple[Trial, ...]]
) -> None:
    large = trials(replace(arch_model, listed_states=0))
    assert large.keys() == wanted.keys()
    numbers = {pair: number for number, pair in enumerate(large)}
    system = replace(arch_model, costs=MeasuredCosts("time", numbers), listed_states=0).transition_system()
    for pair, samples in large.items():
        for trial in samples:
            assert system.step(trial.state, trial.action)[1] == numbers[pair]
    assert {trial.action.split()[1] for trial in large["transport", "san", "bin1[0]"]} == {"blue", "pink", "green"}


def test_simulated_actions_together_take_what_they_take_in_an_execution(scene: Scene) -> None:
    again = ["grasp pink", "transport pink bin1"]
    actions = ["transit top", "grasp pink", "transport pink san", "release pink san", *again]
    steps = execute(scene, actions).steps
    before = [scene.model.initial_state, *(step.predicted for step in steps)]
    trials_of_steps = map(Trial, before, actions)
    predicted = sum(simulate(scene, trial).energy for trial in trials_of_steps)
    assert predicted == pytest.approx(sum(step.effort.energy for step in steps), rel=0.02)


@pytest.mark.parametrize("slot", [0, 1])
def test_objects_lie_in_the_slots_that_a_state_says(scene: Scene, slot: int) -> None:
    places = (("pink", "bin1"), ("green", "right"))
    both = ManipulationState("bin1", "blue", places, slots=(("pink", 1 - slot),), hand_slot=slot)
    effort = simulate(scene, Trial(both, "release blue bin1"))
    alone = ManipulationState("bin1", "blue", (("pink", "table"), ("green", "right")), hand_slot=slot)
    moved = simulate(scene, Trial(alone, "release blue bin1"))
    # Alone it belongs into the first slot, so that from the second the hand has to move on.
    assert (moved.travel > effort.travel + 0.1) == (slot == 1)


@pytest.mark.parametrize("taken", [(), (1,), (0, 2)])
def test_the_arm_puts_an_object_where_the_model_expects_it(taken: tuple[int, ...]) -> None:
    places = (Location("desk", at=(0.45, 0.25)), Location("tray", at=(0.5, -0.2), capacity=3, kind="bin"))
    objects = (Object("cup", "desk"), *(Object(f"block{i}", "tray") for i in taken))
    slots = tuple((f"block{i}", i) for i in taken)
    begin = ManipulationState("home", None, tuple((obj.name, obj.start) for obj in objects), slots=slots)
    costs = {"transit": 3, "grasp": 1, "transport": 5, "release": 1}
    scene = build_scene(ManipulationModel("home", costs, places, objects, begin=begin))
    cell = Workcell(scene, initial_state(scene))
    for action in ("transit desk", "grasp cup", "transport cup tray", "release cup tray"):
        perform(cell, action)
    slot = slot_of(scene, true_poses(scene, cell.data), "cup")
    assert slot is not None and (slot.location, slot.index) == ("tray", free_slot(taken, 0, 3))


def test_an_object_is_grasped_so_that_it_can_be_put_down_where_it_goes() -> None:
    places = (Location("desk", at=(0.45, 0.0)), Location("low", at=(0.5, 0.25)))
    roof = Fixture("roof", "box", at=(0.5, 0.25, 0.22), size=(0.25, 0.2, 0.02))
    cup = Object("cup", "desk", kind="cylinder", size=(0.05, 0.06))
    costs = {"transit": 3, "grasp": 1, "transport": 5, "release": 1}
    scene = build_scene(ManipulationModel("home", costs, places, (cup,), fixtures=(roof,)))
    pair: Pair = ("transport", "desk", "low")
    assert isinstance(measure(scene, pair, trials(scene.model)[pair]), Measurement)


def test_whatever_the_arm_moves_by_is_in_the_digest(monkeypatch: pytest.MonkeyPatch) -> None:
    found: set[str] = set()
    queue = ["execution.cost_measurement"]
    root = Path(sim.__file__).parent
    while queue:
        name = queue.pop()
        if name not in found:
            found.add(name)
            path = root / name.replace(".", "/")
            source = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
            tree = ast.parse(source.read_text(encoding="utf-8"))
            imports = [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
            queue += [module.removeprefix("sim.") for module in imports if module.startswith("sim.")]
    # `cache` keeps what the others make, `processes` do what they are given, and `errors` is a file of the digest.
    assert {name.split(".")[0] for name in found} == {*FOLDERS, "cache", "errors", "execution", "processes"}
    before = digest_of_sources()
    assert digest_of_sources() == before
    monkeypatch.setattr(sources, "FOLDERS", FOLDERS[1:])
    assert digest_of_sources() != before


def fail_for(obj: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every simulation with an object in the hand fail, and others take a second."""

    def stand_in(scene: Scene, trial: Trial, skills: object) -> Effort:
        if trial.state.held == obj:
            raise SkillError(f"{obj} is slippery")
        return Effort(1.0, 2.0, 3.0)

    monkeypatch.setattr(cost_measurement, "simulate", stand_in)


def test_the_simulations_that_work_out_count_and_an_action_that_never_does_is_told(
    scene: Scene, wanted: dict[Pair, tuple[Trial, ...]], monkeypatch: pytest.MonkeyPatch
) -> None:
    fail_for("pink", monkeypatch)
    pair: Pair = ("transport", "san", "bin1[0]")
    assert measure(scene, pair, wanted[pair]) == Measurement(pair, {"time": 1.0, "travel": 2.0, "energy": 3.0}, 2)

    other: Pair = ("transit", "san", "left")
    only_pink = tuple(trial for trial in wanted[pair] if "pink" in trial.action)
    failure, one = measure_all(scene, {pair: only_pink, other: wanted[other]})
    assert isinstance(failure, Failure) and failure.pair == pair
    assert "`transport pink bin1` with hand at san, holding pink" in failure.reason
    assert failure.reason.endswith(": pink is slippery")
    assert isinstance(one, Measurement) and one.pair == other


def test_a_start_over_a_location_is_a_location(arch_model: ManipulationModel) -> None:
    model = ManipulationModel("a", arch_model.costs, (Location("a", at=(0.5, 0)), Location("b", at=(0.5, 0.2))), ())
    assert list(trials(model)) == [("transit", "a", "b"), ("transit", "b", "a")]
    one = replace(model, objects=(Object("cup", "b"),))
    assert ("grasp", "a", "a") in trials(one)
