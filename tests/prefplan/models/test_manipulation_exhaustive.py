"""The manipulation model against a simple enumeration of the states of random models."""

from __future__ import annotations

import random
from collections import deque
from typing import NamedTuple

import pytest
from small_models import COSTS

from prefplan import Location, ManipulationModel, ManipulationState, Object


class Plain(NamedTuple):
    """A state of the re-implementation below."""

    hand: str
    held: str | None
    places: tuple[str | None, ...]
    marks: frozenset[tuple[str, str]]


def plain_start(what: ManipulationModel) -> Plain:
    return Plain(what.start, None, tuple(obj.start for obj in what.objects), frozenset())


def plain_steps(what: ManipulationModel, state: Plain) -> list[tuple[str, int, Plain]]:
    """Return (action, cost, successor), rule by rule."""
    spots = {place.name: place for place in what.locations}
    occupied = [place for place in state.places if place is not None]

    def has_space(place: Location) -> bool:
        return occupied.count(place.name) < place.capacity and all(support in occupied for support in place.on)

    def carries_nothing(name: str) -> bool:
        return not any(name in spots[place].on for place in occupied)

    steps: list[tuple[str, int, Plain]] = []
    if state.held is None:
        for name in spots:
            if name != state.hand:
                steps.append((f"transit {name}", 3, state._replace(hand=name)))
        for k, obj in enumerate(what.objects):
            if state.places[k] == state.hand and not obj.fixed and carries_nothing(state.hand):
                lifted = (*state.places[:k], None, *state.places[k + 1 :])
                steps.append((f"grasp {obj.name}", 1, state._replace(held=obj.name, places=lifted)))
        return steps
    k = [obj.name for obj in what.objects].index(state.held)
    for name, place in spots.items():
        if name != state.hand and has_space(place):
            steps.append((f"transport {state.held} {name}", 5, state._replace(hand=name)))
    for name, place in spots.items():
        if name == state.hand and has_space(place):
            marked = state.marks | ({(state.held, place.marks)} if place.marks else set())
            put = (*state.places[:k], name, *state.places[k + 1 :])
            steps.append((f"release {state.held} {name}", 1, Plain(name, None, put, marked)))
    return steps


def plain_label(what: ManipulationModel, state: Plain) -> set[str]:
    names = {f"{obj.name}_{place}" for obj, place in zip(what.objects, state.places, strict=True) if place}
    return names | {f"{obj}_{mark}" for obj, mark in state.marks} | ({f"holding_{state.held}"} if state.held else set())


def as_plain(what: ManipulationModel, state: ManipulationState) -> Plain:
    return Plain(state.hand, state.held, tuple(state.place.get(obj.name) for obj in what.objects), state.marks)


def random_model(seed: int) -> ManipulationModel:
    """Draw a model of 2 to 5 locations and 1 to 3 objects that is well formed."""
    rng = random.Random(seed)
    names = [f"l{k}" for k in range(rng.randint(2, 5))]
    places = []
    for k, name in enumerate(names):
        common = {"capacity": rng.choice((1, 1, 2)), "marks": rng.choice((None, None, "wet", "hot"))}
        on = tuple(rng.sample(names[:k], rng.randint(1, min(2, k)))) if k and rng.random() < 0.4 else ()
        places.append(Location(name, at=None if on else (0.0, 0.0), on=on, **common))
    capacities = {place.name: place.capacity for place in places}
    starts: list[str] = []
    for _ in range(rng.randint(1, 3)):
        fits = [p.name for p in places if capacities[p.name] > starts.count(p.name) and all(s in starts for s in p.on)]
        if fits:
            starts.append(rng.choice(fits))
    objects = [Object(f"o{k}", start, fixed=rng.random() < 0.15) for k, start in enumerate(starts)]
    rng.shuffle(objects)
    rng.shuffle(places)
    return ManipulationModel(rng.choice(["home", *names]), COSTS, tuple(places), tuple(objects))


@pytest.mark.parametrize("seed", range(24))
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
