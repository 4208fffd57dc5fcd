"""Faults: how they are written, and what each does to the simulation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from observers import Before

from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from sim.errors import SimulationError
from sim.execution.executor import Execution
from sim.execution.faults.blind import Blind
from sim.execution.faults.fault import Fault, read_fault
from sim.execution.faults.foreign import Foreign
from sim.execution.faults.knock import Knock
from sim.execution.faults.miss import Miss
from sim.execution.faults.move import Move
from sim.execution.faults.slip import SLIP_DURATION_S, Slip
from sim.execution.pull import Pull
from sim.perception.sensors import true_poses
from sim.simulation.plant import CONTACT_FLICKER_S
from sim.simulation.run import EXCUSED_S
from sim.world.scene import Scene, build_scene, initial_state

LIFT = ["transit top", "grasp pink"]


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("slip@2", Slip(2)),
        ("move:pink@3", Move(3, "pink")),
        ("knock:blue@1", Knock(1, "blue")),
        ("miss:2@4", Miss(4, "2")),
        ("foreign:san@5", Foreign(5, "san")),
        ("blind:1.5@6", Blind(6, "1.5")),
    ],
)
def test_faults_are_read_as_they_are_written(scene: Scene, text: str, fault: Fault) -> None:
    assert read_fault(text, scene.model) == fault
    assert str(fault) == text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("slp@2", "unknown fault 'slp' (did you mean 'slip'?)"),
        ("fire", "unknown fault 'fire' (valid: blind, foreign, knock, miss, move, slip)"),
        ("slip", "must end with @ and the number of an action from 1, as in slip@K"),
        ("move:pink", "must end with @ and the number of an action from 1, as in move:OBJECT@K"),
        ("slip@0", "must end with @ and the number of an action from 1, as in slip@K"),
        ("slip@two", "must end with @ and the number of an action from 1, as in slip@K"),
        ("slip:pink@2", "is written slip@K"),
        ("move@2", "is written move:OBJECT@K"),
        ("move:pnk@2", "unknown object 'pnk' (did you mean 'pink'?)"),
        ("foreign:sun@2", "unknown location 'sun' (did you mean 'san'?)"),
        ("miss:1.5@2", "'1.5' does not say how many grasps are missed, as in miss:N@K"),
        ("blind:inf@2", "'inf' does not say for how many seconds nothing is seen, as in blind:SECONDS@K"),
    ],
)
def test_a_wrong_spelling_is_told_with_what_would_be_right(scene: Scene, text: str, message: str) -> None:
    with pytest.raises(SimulationError) as caught:
        read_fault(text, scene.model)
    assert str(caught.value).startswith(f"'{text}': {message}")


def test_a_fault_that_cannot_happen_in_a_scene_is_refused_with_the_reason(scene: Scene) -> None:
    model = scene.model
    fixed = replace(model, objects=tuple(replace(obj, fixed=True) for obj in model.objects))
    own = replace(model, scene="lab.xml")
    for text, there, reason in (
        ("foreign:top@2", model, "top is on top of objects; unknown objects appear on the table"),
        (
            "foreign:san@2",
            own,
            "unknown objects appear on the usual table only, not in lab.xml",
        ),
        ("slip@2", fixed, "no object is ever grasped"),
        ("miss:1@2", fixed, "no object is ever grasped"),
    ):
        with pytest.raises(SimulationError) as caught:
            read_fault(text, there)
        assert str(caught.value) == f"'{text}': cannot happen: {reason}"


def run_with(scene: Scene, actions: Sequence[str], *faults: str, seed: int = 0) -> Execution:
    """Return an execution after some actions, up to the first that fails."""
    read = [read_fault(text, scene.model) for text in faults]
    run = Execution(scene, initial_state(scene), faults=read, seed=seed)
    for action in actions:
        if not run.step(action):
            break
    return run


def test_a_slip_is_noticed_and_stops_the_transport(scene: Scene) -> None:
    run = run_with(scene, [*LIFT, "transport pink bin2"], "slip@3", seed=5)
    events = {event.kind: event for event in run.cell.events}
    assert events["fault"].detail == {"fault": "slip@3", "object": "pink"}
    assert "contact" not in events, "what falls is no load of the arm, and may touch the table"
    begun = events["fault"].time
    assert begun < events["lost"].time < begun + SLIP_DURATION_S + 0.2
    frames = run.cell.recorder.arrays
    gone = [
        t for t, forces in zip(frames["times"], frames["pad_forces"], strict=True) if t > begun and not forces.any()
    ]
    assert events["lost"].time - gone[0] < CONTACT_FLICKER_S + 0.05 < 0.25
    assert run.steps[-1].action == "transport pink bin2" and "expected pink in the hand" in str(run.reason)
    tool = run.cell.data.site("tcp").xpos
    assert min(np.hypot(*(tool - slot.position)[:2]) for slot in scene.slots["bin2"]) > 0.1, "it went on to the end"
    shares = {load: float(share.max()) for load, share in run.record().load_shares.items()}
    assert max(shares.values()) < 1, shares


def test_missed_grasps_get_no_grip_and_disturb_nothing(scene: Scene) -> None:
    run = run_with(scene, LIFT, "miss:1@2")
    assert "the fingers closed without a firm grip on pink" in str(run.reason)
    assert run.steps[-1].observed.place == {"blue": "left", "pink": "top", "green": "right"}
    assert run.step("grasp pink") is True


def test_a_rehearsal_uses_up_no_miss(scene: Scene) -> None:
    run = run_with(scene, LIFT[:1], "miss:1@2")
    run.injector.begin(2)
    assert run.can_bring(run.steps[-1].observed, "pink", "top", "bin2")
    assert run.step("grasp pink") is False and "without a firm grip on pink" in str(run.reason)


def test_what_is_moved_stands_upright_on_the_table_at_a_place_drawn_by_seed(scene: Scene) -> None:
    before = true_poses(scene, initial_state(scene))["green"].position
    poses = [
        true_poses(scene, run_with(scene, ["transit san"], "move:green@1", seed=seed).cell.data)["green"]
        for seed in (3, 3, 4, 5)
    ]
    for pose in poses:
        assert np.hypot(*(pose.position - before)[:2]) > 0.02
        assert pose.tilt < np.radians(3) and 0.02 < pose.position[2] < 0.03
        assert 0.3 < np.hypot(*pose.position[:2]) < 0.7
    same, again, other, _ = (pose.position for pose in poses)
    assert np.array_equal(same, again) and not np.allclose(same, other, atol=0.01)


def test_what_is_moved_stays_on_a_small_table() -> None:
    costs = {"transit": 1, "grasp": 1, "transport": 1, "release": 1}
    places = (Location("a", at=(0.5, 0.1)), Location("b", at=(0.5, -0.1)))
    scene = build_scene(ManipulationModel("home", costs, places, (Object("x", "a"),)))
    for seed in range(5):
        run = run_with(scene, ["transit b"], "move:x@1", seed=seed)
        assert 0.02 < true_poses(scene, run.cell.data)["x"].position[2] < 0.03


def test_what_was_placed_and_fell_from_the_table_ends_no_run_with_an_error(scene: Scene) -> None:
    run = run_with(scene, [*LIFT, "transport pink bin2", "release pink bin2"])
    assert run.reason is None
    run.cell.data.joint("pink").qpos[:3] = [0.5, 0.3, -1.0]
    run.reground()
    assert "pink" in run.lost and run.record().placement_error == 0


def test_what_is_knocked_over_tumbles(scene: Scene) -> None:
    run = run_with(scene, ["transit san", "transit bin1"], "knock:pink@1")
    assert run.cell.events[0].detail == {"fault": "knock:pink@1", "object": "pink"}
    path = run.cell.recorder.arrays["qpos"][:, scene.mujoco.joint("pink").qposadr[0] :][:, :7]
    turned = 2 * np.arccos(np.clip(np.abs(path[:, 3] * path[0, 3] + np.sum(path[:, 4:7] * path[0, 4:7], axis=1)), 0, 1))
    assert turned.max() > np.radians(45)


def test_an_unknown_object_appears_and_is_seen_from_then_on(scene: Scene) -> None:
    run = run_with(build_scene(scene.model, spares=1), ["transit top"], "foreign:san@2")
    assert run.reason is None and "foreign1" not in run.cell.shapes
    assert run.injector.happened == {}
    assert not run.step("transit san")
    assert str(run.reason).startswith("after `transit san`: an unknown object has appeared at (0.4")
    assert [event.detail.get("object") for event in run.cell.events if event.kind == "fault"] == ["foreign1"]


def test_the_robot_waits_until_it_sees_again_but_not_for_ever(scene: Scene) -> None:
    run = run_with(scene, LIFT, "blind:2@2")
    assert run.reason is None
    assert run.steps[1].end - run.steps[1].start > 2
    run = run_with(scene, LIFT, "blind:9@2")
    assert run.lost_sensor and "nothing has been seen of" in str(run.reason)


def test_a_fault_happens_at_once_if_it_can(scene: Scene) -> None:
    run = run_with(scene, ["transit top"])
    assert not run.injector.inject(Slip(1)), "nothing hangs in the hand"
    assert run.step("grasp pink")
    assert not run.injector.inject(Knock(2, "pink")), "the hand holds it"
    cell = run.cell
    slipped: list[float] = []

    def drop_it_high() -> None:
        if not slipped and cell.data.body("pink").xpos[2] > 0.15 and run.injector.inject(Slip(3)):
            slipped.append(float(cell.data.time))

    Before(cell, drop_it_high)
    assert not run.step("transport pink bin2")
    (fault,) = (event for event in cell.events if event.kind == "fault")
    assert (fault.detail, fault.time) == ({"fault": "slip@3", "object": "pink"}, slipped[0])
    assert "expected pink in the hand" in str(run.reason)


def test_what_is_pulled_follows_the_pointer_and_falls_when_it_is_let_go(scene: Scene) -> None:
    run = run_with(scene, ["transit san"])
    pink, target = run.cell.data.body("pink"), np.array([0.5, -0.1, 0.25])
    pull = Pull()
    run.cell.observers.append(pull)
    pull.target = "pink", target
    run.cell.wait(1.5)
    assert np.linalg.norm(pink.xpos - target) < 0.005
    pull.target = "pink", target - [0.1, 0.0, 0.0]
    run.cell.wait(1.0)
    pull.target = None
    run.cell.wait(1.0)
    assert np.hypot(*(pink.xpos - target)[:2]) > 0.05 and pink.xpos[2] < 0.08
    told = [event for event in run.cell.events if event.kind == "fault"]
    assert [event.detail for event in told] == [{"fault": "pull:pink@1", "object": "pink"}] * 2
    assert told[1].time - told[0].time == pytest.approx(EXCUSED_S, abs=0.02), "its contacts are excused while it lasts"
