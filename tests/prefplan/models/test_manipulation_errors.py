"""Invalid manipulation models: each is refused with a message that names the key."""

from __future__ import annotations

from dataclasses import replace

import pytest
from small_models import model, spot

from prefplan import Location, ManipulationState, ModelError, Object


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
        replace(model(Object("cup", "a")), begin=state).transition_system()
    assert str(caught.value) == message


A, B = spot("a"), spot("b")


@pytest.mark.parametrize(
    ("locations", "objects", "message"),
    [
        ([A, A], [], "locations.a: defined twice"),
        ([A], [Object("o", "a"), Object("o", "a")], "objects.o: defined twice"),
        ([A], [Object("o", "a", size=0.05)], "objects.o.size: must be a tuple of lengths in metres"),  # type: ignore[arg-type]
        ([Location("a")], [], "locations.a: needs exactly one of 'at' (a point on the table) and 'on' (its supports)"),
        ([A, spot("b", on=("a",))], [], "locations.b: needs exactly one of 'at'"),
        (
            [spot("left"), Location("top", on=("lefd",))],
            [],
            "locations.top.on: unknown location 'lefd' (did you mean 'left'?)",
        ),
        ([A, Location("t", on=("t",))], [], "locations.t.on: unknown location 't' (valid: a)"),
        ([Location("t", on=("u",)), Location("u", on=("t",))], [], "locations.t.on: it would rest on itself"),
        ([A, Location("t", on=("a", "a"))], [], "locations.t.on: 'a' is listed twice"),
        ([A, spot("b", clear_of=("c",))], [], "locations.b.clear_of: unknown location 'c' (valid: a, b)"),
        ([spot("a", capacity=0)], [], "locations.a.capacity: must be at least 1, not 0"),
        ([spot("a", capacity=10**400)], [], "locations.a.capacity: must be at most 1000000000"),
        ([A, B], [Object("o", "c")], "objects.o.start: unknown location 'c' (valid: a, b)"),
        (
            [A, B],
            [Object("o", "a"), Object("p", "a")],
            "objects.p.start: o and p start at 'a', which has room for 1",
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


@pytest.mark.parametrize("name", ["two words", "1st", "true", "F", ""])
def test_names_must_be_fit_for_formulas(name: str) -> None:
    with pytest.raises(ModelError, match=f"'{name}' is "):
        model(locations=[spot(name)])
    with pytest.raises(ModelError, match=f"'{name}' is "):
        model(Object(name, "a"))
    with pytest.raises(ModelError, match=f"'{name}' is "):
        model(locations=[spot("a", marks=name)])


def test_a_location_is_not_below_the_table() -> None:
    with pytest.raises(ModelError) as caught:
        model(locations=[Location("a", at=(0.5, 0.0, -0.1))])
    assert str(caught.value) == "locations.a.at: 0.1 m below the table top; the height is at least 0"
