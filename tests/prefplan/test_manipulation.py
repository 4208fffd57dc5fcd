"""The manipulation model: each rule on a small model, and random models against a plain walk over the states."""

from __future__ import annotations

import random
from collections import deque
from typing import Any, NamedTuple

import pytest

from prefplan import Location, ManipulationModel, ManipulationState, ModelError, Object, TransitionSystem

COSTS = {"transit": 3, "grasp": 1, "transport": 5, "release": 1}


def model(
    *objects: Object, locations: list[Location] | None = None, start: str = "home", propositions: tuple[str, ...] = ()
) -> ManipulationModel:
    """Return a model with spots a, b, c unless other locations are given."""
    spots = locations or [Location(name, at=(0.4, 0.1 * k)) for k, name in enumerate("abc")]
    return ManipulationModel(start, COSTS, tuple(spots), objects, frozenset(propositions))


def spot(name: str, **options: Any) -> Location:
    return Location(name, at=(0.5, 0.0), **options)


@pytest.fixture
def arch() -> list[Location]:
    """Two bases and a top that rests on both, and a spare spot."""
    return [Location("top", on=("left", "right")), spot("left"), spot("right"), spot("spare")]


def after(system: TransitionSystem, *actions: str) -> int:
    """Return the state that a plan leads to."""
    state = system.start
    for action in actions:
        state, _ = system.step(state, action)
    return state


def enabled(system: TransitionSystem, *actions: str) -> list[str]:
    """Return what can be done after a plan, in order."""
    return [system.action_names[system.actions[edge]] for edge in system.edges(after(system, *actions))]


def label(system: TransitionSystem, *actions: str) -> frozenset[str]:
    return system.label(after(system, *actions))


def test_case_study_3_has_10009_states_and_59407_transitions(case_study_3_model: ManipulationModel) -> None:
    system = case_study_3_model.transition_system()
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


@pytest.mark.parametrize(
    ("state", "message"),
    [
        (ManipulationState("home", None, ()), "start: 'cup' is neither at a location nor in the hand"),
        (ManipulationState("home", None, (("cup", "d"),)), "start: 'cup' at unknown location 'd' (valid: a, b, c)"),
        (ManipulationState("home", "cut", (("cup", "a"),)), "start: unknown object 'cut' (did you mean 'cup'?)"),
        (ManipulationState("home", "cup", (), frozenset({("cup", "hot")})), "start: 'cup' cannot be marked 'hot'"),
    ],
)
def test_a_start_that_does_not_fit_the_model_is_refused(state: ManipulationState, message: str) -> None:
    with pytest.raises(ModelError) as caught:
        model(Object("cup", "a")).transition_system(start=state)
    assert str(caught.value) == message


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


class Plain(NamedTuple):
    """A state of the re-implementation below."""

    hand: str
    held: str | None
    places: tuple[str | None, ...]
    marks: frozenset[tuple[str, str]]


def plain_start(what: ManipulationModel) -> Plain:
    return Plain(what.start, None, tuple(thing.start for thing in what.objects), frozenset())


def plain_steps(what: ManipulationModel, state: Plain) -> list[tuple[str, int, Plain]]:
    """Return (action, cost, successor), rule by rule."""
    spots = {place.name: place for place in what.locations}
    occupied = [place for place in state.places if place is not None]

    def has_room(place: Location) -> bool:
        return occupied.count(place.name) < place.capacity and all(support in occupied for support in place.on)

    def carries_nothing(name: str) -> bool:
        return not any(name in spots[place].on for place in occupied)

    steps: list[tuple[str, int, Plain]] = []
    if state.held is None:
        for name in spots:
            if name != state.hand:
                steps.append((f"transit {name}", 3, state._replace(hand=name)))
        for k, thing in enumerate(what.objects):
            if state.places[k] == state.hand and not thing.fixed and carries_nothing(state.hand):
                lifted = (*state.places[:k], None, *state.places[k + 1 :])
                steps.append((f"grasp {thing.name}", 1, state._replace(held=thing.name, places=lifted)))
        return steps
    k = [thing.name for thing in what.objects].index(state.held)
    for name, place in spots.items():
        if name != state.hand and has_room(place):
            steps.append((f"transport {state.held} {name}", 5, state._replace(hand=name)))
    for name, place in spots.items():
        if name == state.hand and has_room(place):
            marked = state.marks | ({(state.held, place.marks)} if place.marks else set())
            put = (*state.places[:k], name, *state.places[k + 1 :])
            steps.append((f"release {state.held} {name}", 1, Plain(name, None, put, marked)))
    return steps


def plain_label(what: ManipulationModel, state: Plain) -> set[str]:
    names = {f"{thing.name}_{place}" for thing, place in zip(what.objects, state.places, strict=True) if place}
    return (
        names
        | {f"{thing}_{mark}" for thing, mark in state.marks}
        | ({f"holding_{state.held}"} if state.held else set())
    )


def as_plain(what: ManipulationModel, state: ManipulationState) -> Plain:
    return Plain(state.hand, state.held, tuple(state.place.get(thing.name) for thing in what.objects), state.marks)


def random_model(seed: int) -> ManipulationModel:
    """Draw a model of 2 to 5 locations and 1 to 3 objects that is well formed."""
    rng = random.Random(seed)
    names = [f"l{k}" for k in range(rng.randint(2, 5))]
    places = []
    for k, name in enumerate(names):
        common = {"capacity": rng.choice((1, 1, 2)), "marks": rng.choice((None, None, "wet", "hot"))}
        on = tuple(rng.sample(names[:k], rng.randint(1, min(2, k)))) if k and rng.random() < 0.4 else ()
        places.append(Location(name, at=None if on else (0.0, 0.0), on=on, **common))
    room = {place.name: place.capacity for place in places}
    starts: list[str] = []
    for _ in range(rng.randint(1, 3)):
        fits = [p.name for p in places if room[p.name] > starts.count(p.name) and all(s in starts for s in p.on)]
        if fits:
            starts.append(rng.choice(fits))
    objects = [Object(f"o{k}", start, fixed=rng.random() < 0.15) for k, start in enumerate(starts)]
    rng.shuffle(objects)
    rng.shuffle(places)
    return ManipulationModel(rng.choice(["home", *names]), COSTS, tuple(places), tuple(objects))


@pytest.mark.parametrize("seed", range(80))
def test_random_models_agree_with_a_plain_walk_over_the_states(seed: int) -> None:
    what = random_model(seed)
    system = what.transition_system()
    number = {as_plain(what, state): k for k, state in enumerate(system.states)}
    assert len(number) == system.size
    first = plain_start(what)
    assert number[first] == system.start
    seen, queue = {first}, deque([first])
    while queue:
        state = queue.popleft()
        k = number[state]
        steps = plain_steps(what, state)
        assert [system.action_names[system.actions[edge]] for edge in system.edges(k)] == [
            action for action, *_ in steps
        ]
        assert [system.targets[edge] for edge in system.edges(k)] == [number[after] for *_, after in steps]
        assert [system.costs[edge] for edge in system.edges(k)] == [cost for _, cost, _ in steps]
        assert system.label(k) == plain_label(what, state)
        for *_, successor in steps:
            if successor not in seen:
                seen.add(successor)
                queue.append(successor)
    assert seen == set(number)


A, B = spot("a"), spot("b")


@pytest.mark.parametrize(
    ("locations", "objects", "message"),
    [
        ([A, A], [], "locations.a: defined twice"),
        ([A], [Object("o", "a"), Object("o", "a")], "objects.o: defined twice"),
        ([Location("a")], [], "locations.a: needs exactly one of 'at' (a point on the table) and 'on' (its supports)"),
        ([A, spot("b", on=("a",))], [], "locations.b: needs exactly one of 'at'"),
        (
            [spot("left"), Location("top", on=("lefd",))],
            [],
            "locations.top.on: unknown location 'lefd' (did you mean 'left'?)",
        ),
        ([A, Location("t", on=("t",))], [], "locations.t.on: unknown location 't' (valid: a)"),
        ([Location("t", on=("u",)), Location("u", on=("t",))], [], "locations.t.on: it would rest on itself"),
        ([A, spot("b", clear_of=("c",))], [], "locations.b.clear_of: unknown location 'c' (valid: a, b)"),
        ([spot("a", capacity=0)], [], "locations.a.capacity: must be at least 1, not 0"),
        ([A, B], [Object("o", "c")], "objects.o.start: unknown location 'c' (valid: a, b)"),
        (
            [A, B],
            [Object("o", "a"), Object("p", "a")],
            "objects.p.start: o and p both start at 'a', which has room for 1",
        ),
        (
            [A, Location("t", on=("a",))],
            [Object("o", "t")],
            "objects.o.start: 't' rests on 'a', where no object starts",
        ),
    ],
)
def test_what_makes_no_sense_is_refused(locations: list[Location], objects: list[Object], message: str) -> None:
    with pytest.raises(ModelError) as caught:
        model(*objects, locations=locations)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("locations", "objects", "name"),
    [
        ([A, spot("b", marks="a")], [Object("o", "b")], "o_a"),
        ([spot("b_c"), spot("c")], [Object("a", "c"), Object("a_b", "b_c")], "a_b_c"),
        ([spot("x"), spot("holding_x")], [Object("holding", "holding_x"), Object("x", "x")], "holding_x"),
        ([spot("a", marks="c"), spot("b_c")], [Object("o", "a"), Object("o_b", "b_c")], "o_b_c"),
    ],
)
def test_two_names_that_give_the_same_proposition_clash(
    locations: list[Location], objects: list[Object], name: str
) -> None:
    with pytest.raises(ModelError, match=f"proposition '{name}' would mean both"):
        model(*objects, locations=locations)


@pytest.mark.parametrize(
    ("costs", "message"),
    [
        ({**COSTS, "grasp": -1}, "costs.grasp: negative cost -1"),
        ({"transit": 1, "grasp": 1, "release": 1}, "costs: no cost for 'transport'"),
        ({**COSTS, "graps": 1}, "costs: unknown action 'graps' (did you mean 'grasp'?)"),
    ],
)
def test_every_kind_of_action_needs_a_cost(costs: dict[str, int], message: str) -> None:
    with pytest.raises(ModelError) as caught:
        ManipulationModel("home", costs, (A,), ())
    assert str(caught.value) == message


@pytest.mark.parametrize("name", ["two words", "1st", "true", "F", ""])
def test_names_must_be_fit_for_formulas(name: str) -> None:
    with pytest.raises(ModelError, match=f"'{name}' is "):
        model(locations=[spot(name)])
    with pytest.raises(ModelError, match=f"'{name}' is "):
        model(Object(name, "a"))
    with pytest.raises(ModelError, match=f"'{name}' is "):
        model(locations=[spot("a", marks=name)])
