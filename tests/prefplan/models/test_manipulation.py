"""The manipulation model on small tables; `test_manipulation_exhaustive` has the rules of every action."""

from __future__ import annotations

from dataclasses import replace

import pytest
from small_models import after, enabled, label, model, spot

from prefplan import Location, ManipulationModel, ManipulationState, Object


@pytest.fixture
def arch() -> list[Location]:
    """Two bases and a top that rests on both, and a spare spot."""
    return [Location("top", on=("left", "right")), spot("left"), spot("right"), spot("spare")]


def test_case_study_3_has_10009_states_and_59407_transitions(arch_model: ManipulationModel) -> None:
    system = arch_model.transition_system().listed
    assert (system.size, len(system.targets)) == (10009, 59407)


def test_actions_come_by_kind_then_in_file_order() -> None:
    places = [spot("z", capacity=2), spot("y")]
    system = model(Object("jug", "z"), Object("cup", "z"), locations=places).transition_system().listed
    assert system.action_names == (
        *("transit z", "transit y", "grasp jug", "grasp cup"),
        *("transport jug z", "transport jug y", "transport cup z", "transport cup y"),
        *("release jug z", "release jug y", "release cup z", "release cup y"),
    )
    assert enabled(system, "transit z") == ["transit y", "grasp jug", "grasp cup"]


def test_every_proposition_may_be_used_even_if_it_never_holds() -> None:
    system = model(Object("cup", "a"), propositions=("fire",)).transition_system().listed
    assert system.propositions == {"cup_a", "cup_b", "cup_c", "holding_cup", "fire"}


def test_states_tell_in_words_what_they_are() -> None:
    system = model(Object("cup", "a"), Object("jug", "b")).transition_system().listed
    first = system.states[system.start]
    assert first == ManipulationState("home", None, (("cup", "a"), ("jug", "b")))
    assert str(first) == "hand at home, cup on a, jug on b"
    held = system.states[after(system, "transit a", "grasp cup")]
    assert (held.hand, held.held, held.place) == ("a", "cup", {"jug": "b"})
    assert system.states[0:2] == (system.states[0], system.states[1])


def test_any_state_may_be_the_start(arch: list[Location]) -> None:
    objects = [Object("beam", "top"), Object("base", "left"), Object("prop", "right")]
    what = model(*objects, locations=arch)
    whole = what.transition_system().listed
    reached = after(whole, "transit top", "grasp beam", "transport beam spare")
    system = replace(what, begin=whole.states[reached]).transition_system().listed  # type: ignore[arg-type]
    assert system.states[system.start] == whole.states[reached]
    assert enabled(system) == enabled(whole, "transit top", "grasp beam", "transport beam spare")
    assert label(system) == whole.label(reached)


def test_a_start_with_a_full_hand_keeps_marks_and_an_unknown_pose_is_left_for_good() -> None:
    what = model(Object("cup", "sink"), locations=[spot("sink", marks="clean"), spot("rack")])
    begun = ManipulationState("no location", "cup", (), frozenset({("cup", "clean")}))
    system = replace(what, begin=begun).transition_system().listed
    assert label(system) == {"holding_cup", "cup_clean"}
    assert enabled(system) == ["transport cup sink", "transport cup rack"]
    assert label(system, "transport cup rack", "release cup rack") == {"cup_rack", "cup_clean"}
    assert [state.hand for state in system.states].count("no location") == 1


def test_objects_are_taken_from_a_closed_location_and_never_put_there() -> None:
    what = model(Object("cup", "lost"), locations=[spot("a"), spot("lost", closed=True)], start="lost")
    system = what.transition_system().listed
    assert "grasp cup" in enabled(system)
    assert enabled(system, "grasp cup") == ["transport cup a"]
    assert enabled(system, "grasp cup", "transport cup a") == ["release cup a"]


def test_nothing_is_put_where_an_object_obstructs() -> None:
    places = [spot("a", clear_of=("lost",)), spot("b"), spot("lost", closed=True)]
    system = model(Object("cup", "b"), Object("jug", "lost"), locations=places).transition_system().listed
    assert enabled(system, "transit b", "grasp cup") == ["release cup b"]
    tidied = ("transit lost", "grasp jug", "transport jug a", "release jug a")
    assert "release jug a" in enabled(system, *tidied[:3])
    assert "transport jug a" not in enabled(system, "transit b", "grasp cup")


def test_nothing_is_taken_from_a_closed_location_while_an_object_obstructs() -> None:
    places = [spot("a"), spot("lost", closed=True, clear_of=("b",)), spot("b")]
    system = model(Object("cup", "lost"), Object("jug", "b"), locations=places).transition_system().listed
    assert "grasp cup" not in enabled(system, "transit lost")
    assert "grasp cup" in enabled(system, "transit b", "grasp jug", "transport jug a", "release jug a", "transit lost")
