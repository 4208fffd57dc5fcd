"""Regrounding: models and scenes that are extended to fit an observation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from prefplan.models.manipulation.action_costs import MeasuredCosts
from prefplan.models.manipulation.model import Location, ManipulationState
from sim.perception.grounding import NOWHERE, observe
from sim.perception.sensors import ObjectPose, true_poses
from sim.perception.world_model import reground, spots_in
from sim.world.scene import Scene, build_scene, initial_state


class Regrounded(NamedTuple):
    """What `reground` returned."""

    scene: Scene
    lost: dict[str, str]

    @property
    def state(self) -> ManipulationState:
        return self.scene.model.initial_state


See = Callable[..., Regrounded]


@pytest.fixture
def see(scene: Scene) -> See:
    """Return a function that regrounds the arch with objects elsewhere: name = (x, y, z)."""

    def regrounded(
        hand: str = "home",
        held: str | None = None,
        reach: float = 0.7,
        marks: frozenset[tuple[str, str]] = frozenset(),
        **points: tuple[float, float, float],
    ) -> Regrounded:
        data = initial_state(scene)
        poses = true_poses(scene, data)
        for obj, point in points.items():
            poses[obj] = ObjectPose(poses[obj].shape, np.array(point), np.eye(3))

        def lost_because(obj: str) -> str | None:
            return None if np.hypot(*poses[obj].position[:2]) < reach else "is out of reach"

        return Regrounded(*reground(scene, data, poses, hand=hand, held=held, marks=marks, lost_because=lost_because))

    return regrounded


def location(found: Regrounded, name: str) -> Location:
    return found.scene.model.location(name)


def test_what_is_as_the_scenario_has_it_stays_so(scene: Scene, see: See) -> None:
    found = see()
    assert found.state == scene.model.initial_state and found.lost == {}
    assert found.scene.model.locations == scene.model.locations


def test_what_is_fixed_stays_fixed(scene: Scene) -> None:
    objects = tuple(replace(obj, fixed=obj.name == "green") for obj in scene.model.objects)
    fixed, data = replace(scene, model=replace(scene.model, objects=objects)), initial_state(scene)
    poses = true_poses(scene, data)
    found = Regrounded(
        *reground(fixed, data, poses, hand="home", held=None, marks=frozenset(), lost_because=lambda obj: None)
    )
    assert [obj.name for obj in found.scene.model.objects if obj.fixed] == ["green"]


def test_what_lies_off_every_location_gets_one_to_be_taken_from(see: See) -> None:
    found = see(pink=(0.45, 0.12, 0.0225))
    assert found.state.place == {"blue": "left", "pink": "spot1", "green": "right"}
    assert location(found, "spot1") == Location("spot1", at=(0.45, 0.12), closed=True)
    (slot,) = found.scene.slots["spot1"]
    spots = spots_in(["transit spot1", "grasp pink"], found.scene, found.state)
    assert spots == {"spot1": {"object": "pink", "at": [0.45, 0.12]}}
    assert spots_in(["grasp blue", "transport blue san"], found.scene, found.state) == {}
    assert np.allclose(slot.position, [0.45, 0.12, 0.0])
    system = found.scene.model.transition_system().listed
    assert system.states[system.start] == found.state
    assert "transport blue spot1" not in {system.action_names[action] for action in system.actions}


def test_where_costs_are_measured_the_slots_are_seen_that_objects_lie_in(scene: Scene) -> None:
    measured = replace(scene, model=replace(scene.model, costs=MeasuredCosts("energy")))
    data = initial_state(scene)
    poses = true_poses(scene, data)
    second = scene.slots["bin1"][1].position + [0.0, 0.0, 0.0225]
    poses["pink"] = replace(poses["pink"], position=second)
    see = partial(reground, data=data, poses=poses, hand="home", held=None, marks=frozenset())
    for model, slots in ((measured, (("pink", 1),)), (scene, ())):
        assert Regrounded(*see(model, lost_because=lambda obj: None)).state.slots == slots


def test_what_it_lies_on_cannot_be_taken_before_it_is_gone(see: See) -> None:
    found = see(pink=(0.62, 0.235, 0.0675), green=(0.62, 0.20, 0.0225))
    assert found.state.place == {"blue": "left", "pink": "spot1", "green": "table"}
    assert location(found, "spot1").on == ("table",) and location(found, "spot1").at is None
    system = found.scene.model.transition_system().listed
    at_table, _ = system.step(system.start, "transit table")
    assert "grasp green" not in {system.action_names[system.actions[edge]] for edge in system.edges(at_table)}


def test_nothing_is_put_where_something_lies_half_in_the_way(see: See) -> None:
    found = see(pink=(0.62, 0.151, 0.0225))
    assert location(found, "table").clear_of == ("spot1",)
    assert location(found, "san").clear_of == location(found, "bin1").clear_of == ()


def test_what_is_in_the_way_and_out_of_reach_closes_a_location(see: See) -> None:
    found = see(pink=(0.669, 0.20, 0.0225), reach=0.66)
    assert found.lost == {"pink": "is out of reach"} and location(found, "table").closed
    (pink,) = (obj for obj in found.scene.model.objects if obj.name == "pink")
    assert pink.fixed


def test_what_fell_from_the_table_is_no_longer_in_the_model(see: See) -> None:
    marks = frozenset({("pink", "sanitized"), ("blue", "sanitized")})
    found = see(pink=(1.0, 0.0, -5.0), marks=marks)
    assert found.lost == {"pink": "fell from the table"}
    assert [obj.name for obj in found.scene.model.objects] == ["blue", "green"]
    assert found.state.place == {"blue": "left", "green": "right"}
    label = found.scene.model.transition_system().listed.label(0)
    assert "blue_sanitized" in label and "pink_sanitized" not in label


def test_what_fell_before_is_not_observed_any_more(scene: Scene) -> None:
    data = initial_state(scene)
    poses = true_poses(scene, data)
    del poses["pink"]
    found = Regrounded(
        *reground(scene, data, poses, hand="home", held=None, marks=frozenset(), lost_because=lambda obj: None)
    )
    assert found.lost == {"pink": "fell from the table"}
    assert [obj.name for obj in found.scene.model.objects] == ["blue", "green"]
    system = found.scene.model.transition_system().listed
    assert system.states[system.start] == found.state


def test_of_two_objects_at_a_location_for_one_the_nearer_is_there(see: See) -> None:
    found = see(pink=(0.62, 0.195, 0.0225), green=(0.62, 0.242, 0.0225))
    assert found.state.place["pink"] == "table" and found.state.place["green"] == "spot1"


def test_what_lay_off_a_location_is_at_it_as_soon_as_it_rests_there_alone(scene: Scene, see: See) -> None:
    pink, green = (0.62, 0.195, 0.0225), (0.62, 0.242, 0.0225)
    found = see(pink=pink, green=green)
    poses = true_poses(scene, initial_state(scene))
    for obj, point in (("pink", pink), ("green", green)):
        poses[obj] = replace(poses[obj], position=np.array(point))
    data = initial_state(scene)
    assert observe(found.scene, data, poses, hand="home", held=None).place == found.state.place
    alone = observe(found.scene, data, poses, hand="home", held="pink")
    assert alone.place == {"blue": "left", "green": "table"}


def tilted(degrees: float) -> np.ndarray:
    return Rotation.from_euler("x", degrees, degrees=True).as_matrix()


def test_what_leant_beside_a_slot_is_at_it_as_soon_as_it_stands(scene: Scene) -> None:
    data = initial_state(scene)
    poses = true_poses(scene, data)
    poses["pink"] = replace(poses["pink"], position=np.array([0.62, 0.235, 0.0285]), rotation=tilted(21))
    found = Regrounded(
        *reground(scene, data, poses, hand="home", held=None, marks=frozenset(), lost_because=lambda obj: None)
    )
    assert found.state.place["pink"] == "spot1"
    poses["pink"] = replace(poses["pink"], rotation=tilted(19))
    assert observe(found.scene, data, poses, hand="home", held=None).place["pink"] == "table"


def test_an_object_between_two_slots_leaves_no_room_for_another(scene: Scene, see: See) -> None:
    middle = np.mean([slot.position for slot in scene.slots["bin1"]], axis=0) + [0.0, 0.0, 0.0225]
    found = see(pink=tuple(middle))
    assert found.state.place["pink"] == "bin1"
    assert location(found, "bin1").clear_of == ("bin1",)


def test_the_hand_is_nowhere_unless_it_is_over_a_location_or_never_left(see: See) -> None:
    assert see(hand="home").state.hand == "home"
    assert see(hand="san").state.hand == NOWHERE
    assert see(hand="spot1").state.hand == NOWHERE


def test_unknown_objects_join_the_model_also_in_the_hand(scene: Scene) -> None:
    stocked = build_scene(scene.model, spares=1)
    data = initial_state(stocked)
    poses = true_poses(stocked, data)
    poses["foreign1"] = ObjectPose(stocked.shapes["foreign1"], np.array([0.45, 0.30, 0.0265]), np.eye(3))
    for held, place in ((None, {"foreign1": "san"}), ("foreign1", {})):
        found = Regrounded(
            *reground(stocked, data, poses, hand="home", held=held, marks=frozenset(), lost_because=lambda obj: None)
        )
        assert found.state == ManipulationState("home", held, (*scene.model.initial_state.places, *place.items()))
        system = found.scene.model.transition_system().listed
        assert {"transport foreign1 bin1", "release foreign1 bin2"} <= set(system.action_names)
