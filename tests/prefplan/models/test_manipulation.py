"""The manipulation model: each rule on a small table."""

from __future__ import annotations

import pytest
from small_models import after, enabled, label, model, spot

from prefplan import Location, ManipulationModel, ManipulationState, Object


@pytest.fixture
def arch() -> list[Location]:
    """Two bases and a top that rests on both, and a spare spot."""
    return [Location("top", on=("left", "right")), spot("left"), spot("right"), spot("spare")]


def test_case_study_3_has_10009_states_and_59407_transitions(arch_model: ManipulationModel) -> None:
    system = arch_model.transition_system()
    assert (system.size, len(system.targets)) == (10009, 59407)


def test_an_empty_hand_may_go_to_any_other_location_occupied_or_not() -> None:
    system = model(Object("cup", "a")).transition_system()
    assert enabled(system) == ["transit a", "transit b", "transit c"]
    assert enabled(system, "transit b") == ["transit a", "transit c"]
    assert enabled(system, "transit a") == ["transit b", "transit c", "grasp cup"]


def test_a_start_pose_is_left_for_good() -> None:
    system = model(Object("cup", "a")).transition_system()
    assert "transit home" not in system.action_names
    assert [state.hand for state in system.states].count("home") == 1


def test_the_hand_may_start_at_a_location_and_come_back() -> None:
    system = model(Object("cup", "a"), start="a").transition_system()
    assert enabled(system) == ["transit b", "transit c", "grasp cup"]
    assert after(system, "transit b", "transit a") == system.start


def test_an_object_is_grasped_only_where_the_hand_is() -> None:
    system = model(Object("cup", "a"), Object("jug", "b")).transition_system()
    assert [action for action in enabled(system, "transit b") if action.startswith("grasp")] == ["grasp jug"]


def test_a_full_hand_neither_grasps_nor_transits() -> None:
    system = model(Object("cup", "a"), Object("jug", "b")).transition_system()
    assert enabled(system, "transit a", "grasp cup") == ["transport cup c", "release cup a"]
    assert enabled(system, "transit a", "grasp cup", "transport cup c") == ["transport cup a", "release cup c"]


def test_transport_and_release_need_room() -> None:
    roomy = [spot("a"), spot("b"), spot("bin", capacity=2)]
    objects = [Object("cup", "a"), Object("jug", "b"), Object("pot", "bin")]
    system = model(*objects, locations=roomy).transition_system()
    first = ("transit a", "grasp cup", "transport cup bin", "release cup bin")
    assert "transport cup b" not in enabled(system, "transit a", "grasp cup")
    assert "transport cup bin" in enabled(system, "transit a", "grasp cup")
    assert "transport jug bin" not in enabled(system, *first, "transit b", "grasp jug")
    assert {"grasp cup", "grasp pot"} <= set(enabled(system, *first))


def test_something_below_another_object_is_not_grasped(arch: list[Location]) -> None:
    objects = [Object("beam", "top"), Object("base", "left"), Object("prop", "right")]
    system = model(*objects, locations=arch).transition_system()
    assert "grasp base" not in enabled(system, "transit left")
    cleared = ("transit top", "grasp beam", "transport beam spare", "release beam spare")
    assert "grasp base" in enabled(system, *cleared, "transit left")


def test_what_rests_on_supports_needs_an_object_on_each(arch: list[Location]) -> None:
    objects = [Object("beam", "spare"), Object("base", "left"), Object("prop", "right")]
    system = model(*objects, locations=arch).transition_system()
    assert "transport beam top" in enabled(system, "transit spare", "grasp beam")
    assert "transport base top" not in enabled(system, "transit left", "grasp base")
    lonely = model(Object("beam", "spare"), Object("base", "left"), locations=arch).transition_system()
    assert "transport beam top" not in enabled(lonely, "transit spare", "grasp beam")
    assert not any("beam_top" in names for names in lonely.label_sets)


def test_a_fixed_object_is_never_grasped_but_supports_others(arch: list[Location]) -> None:
    objects = [Object("beam", "spare"), Object("base", "left", fixed=True), Object("prop", "right", fixed=True)]
    system = model(*objects, locations=arch).transition_system()
    assert "grasp base" not in enabled(system, "transit left")
    assert "beam_top" in label(
        system, "transit spare", "grasp beam", "transport beam top", "release beam top", "transit left"
    )


def test_labels_say_where_objects_rest_and_what_is_held() -> None:
    system = model(Object("cup", "a"), Object("jug", "b"), start="a").transition_system()
    assert label(system) == {"cup_a", "jug_b"}
    assert label(system, "grasp cup") == {"holding_cup", "jug_b"}
    assert label(system, "grasp cup", "transport cup c") == {"holding_cup", "jug_b"}
    assert label(system, "grasp cup", "transport cup c", "release cup c") == {"cup_c", "jug_b"}


def test_a_mark_is_left_by_the_first_release_and_stays() -> None:
    system = model(
        Object("cup", "sink"), locations=[spot("sink", marks="clean"), spot("rack")], start="sink"
    ).transition_system()
    assert label(system) == {"cup_sink"}
    assert label(system, "grasp cup", "transport cup rack", "release cup rack") == {"cup_rack"}
    assert label(system, "grasp cup", "release cup sink") == {"cup_sink", "cup_clean"}
    assert label(system, "grasp cup", "release cup sink", "grasp cup") == {"holding_cup", "cup_clean"}
    assert label(system, "grasp cup", "release cup sink", "grasp cup", "transport cup rack", "release cup rack") == {
        "cup_rack",
        "cup_clean",
    }


def test_two_places_may_leave_the_same_mark() -> None:
    places = [spot("sink", marks="clean"), spot("tub", marks="clean"), spot("fire", marks="hot")]
    system = model(Object("cup", "fire"), locations=places, start="fire").transition_system()
    one = label(system, "grasp cup", "transport cup sink", "release cup sink")
    other = label(system, "grasp cup", "transport cup tub", "release cup tub")
    assert (one, other) == ({"cup_sink", "cup_clean"}, {"cup_tub", "cup_clean"})
    assert {"cup_clean", "cup_hot"} <= system.propositions


def test_actions_come_by_kind_then_in_file_order() -> None:
    places = [spot("z", capacity=2), spot("y")]
    system = model(Object("jug", "z"), Object("cup", "z"), locations=places).transition_system()
    assert system.action_names == (
        *("transit z", "transit y", "grasp jug", "grasp cup"),
        *("transport jug z", "transport jug y", "transport cup z", "transport cup y"),
        *("release jug z", "release jug y", "release cup z", "release cup y"),
    )
    assert enabled(system, "transit z") == ["transit y", "grasp jug", "grasp cup"]


def test_each_kind_of_action_has_its_cost() -> None:
    system = model(Object("cup", "a")).transition_system()
    state, costs = system.start, []
    for action in ("transit a", "grasp cup", "transport cup b", "release cup b"):
        state, cost = system.step(state, action)
        costs.append(cost)
    assert costs == [3, 1, 5, 1]


def test_every_proposition_may_be_used_even_if_it_never_holds() -> None:
    system = model(Object("cup", "a"), propositions=("fire",)).transition_system()
    assert system.propositions == {"cup_a", "cup_b", "cup_c", "holding_cup", "fire"}


def test_states_tell_in_words_what_they_are() -> None:
    system = model(Object("cup", "a"), Object("jug", "b")).transition_system()
    first = system.states[system.start]
    assert first == ManipulationState("home", None, (("cup", "a"), ("jug", "b")))
    assert str(first) == "hand at home, cup on a, jug on b"
    held = system.states[after(system, "transit a", "grasp cup")]
    assert (held.hand, held.held, held.place) == ("a", "cup", {"jug": "b"})
    assert system.states[0:2] == [system.states[0], system.states[1]]


def test_any_state_may_be_the_start(arch: list[Location]) -> None:
    objects = [Object("beam", "top"), Object("base", "left"), Object("prop", "right")]
    what = model(*objects, locations=arch)
    whole = what.transition_system()
    reached = after(whole, "transit top", "grasp beam", "transport beam spare")
    system = what.transition_system(start=whole.states[reached])  # type: ignore[arg-type]
    assert system.states[system.start] == whole.states[reached]
    assert enabled(system) == enabled(whole, "transit top", "grasp beam", "transport beam spare")
    assert label(system) == whole.label(reached)


def test_a_start_in_the_middle_of_things_keeps_marks_and_an_unknown_pose_is_left_for_good() -> None:
    what = model(Object("cup", "sink"), locations=[spot("sink", marks="clean"), spot("rack")])
    begun = ManipulationState("no location", "cup", (), frozenset({("cup", "clean")}))
    system = what.transition_system(start=begun)
    assert label(system) == {"holding_cup", "cup_clean"}
    assert enabled(system) == ["transport cup sink", "transport cup rack"]
    assert label(system, "transport cup rack", "release cup rack") == {"cup_rack", "cup_clean"}
    assert [state.hand for state in system.states].count("no location") == 1


def test_things_are_taken_from_a_closed_location_and_never_put_there() -> None:
    what = model(Object("cup", "lost"), locations=[spot("a"), spot("lost", closed=True)], start="lost")
    system = what.transition_system()
    assert "grasp cup" in enabled(system)
    assert enabled(system, "grasp cup") == ["transport cup a"]
    assert enabled(system, "grasp cup", "transport cup a") == ["release cup a"]


def test_nothing_is_put_where_something_lies_in_the_way() -> None:
    places = [spot("a", clear_of=("lost",)), spot("b"), spot("lost", closed=True)]
    system = model(Object("cup", "b"), Object("jug", "lost"), locations=places).transition_system()
    assert enabled(system, "transit b", "grasp cup") == ["release cup b"]
    tidied = ("transit lost", "grasp jug", "transport jug a", "release jug a")
    assert "release jug a" in enabled(system, *tidied[:3])
    assert "transport jug a" not in enabled(system, "transit b", "grasp cup")


def test_nothing_is_taken_from_a_closed_location_while_another_is_in_the_way() -> None:
    places = [spot("a"), spot("lost", closed=True, clear_of=("b",)), spot("b")]
    system = model(Object("cup", "lost"), Object("jug", "b"), locations=places).transition_system()
    assert "grasp cup" not in enabled(system, "transit lost")
    assert "grasp cup" in enabled(system, "transit b", "grasp jug", "transport jug a", "release jug a", "transit lost")
