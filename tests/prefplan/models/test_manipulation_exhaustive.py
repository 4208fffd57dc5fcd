"""The manipulation model against a simple enumeration of the states of random models."""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

import judge
import pytest
from random_manipulation import random_measured
from small_models import COSTS

from prefplan import Location, ManipulationModel, ManipulationState, Object


def random_model(rng: random.Random) -> ManipulationModel:
    """Draw a model of 2 to 5 locations and 1 to 3 objects that is well formed."""
    names = [f"l{k}" for k in range(rng.randint(2, 5))]
    places = []
    for k, name in enumerate(names):
        on = tuple(rng.sample(names[:k], rng.randint(1, min(2, k)))) if k and rng.random() < 0.4 else ()
        places.append(
            Location(
                name,
                at=None if on else (0.0, 0.0),
                on=on,
                capacity=rng.choice((1, 1, 2, 3)),
                marks=rng.choice((None, None, "wet", "hot")),
                closed=rng.random() < 0.15,
                clear_of=tuple(rng.sample(names, rng.randint(1, 2))) if rng.random() < 0.2 else (),
            )
        )
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


def with_costs(rng: random.Random, what: ManipulationModel) -> ManipulationModel:
    """Draw one or two costs of each kind of action, or measured ones, which tell slots apart."""
    quantities = rng.choice(("time", ("time", "energy")))
    if rng.random() < 0.5:
        return random_measured(rng, what, quantities)
    names = quantities if isinstance(quantities, tuple) else ()
    costs: dict[str, Any] = {
        kind: {name: rng.randint(0, 9) for name in names} or 0.5 * rng.randint(0, 9) for kind in COSTS
    }
    return replace(what, costs=costs)


def random_start(rng: random.Random, what: ManipulationModel) -> ManipulationState:
    """Draw a state with an object in the hand, at times, and some marks."""
    first = what.initial_state
    marks = frozenset((obj.name, mark) for obj in what.objects for mark in what.marks if rng.random() < 0.2)
    held = rng.choice([None, *(obj.name for obj in what.objects if not obj.fixed)])
    places = tuple((obj, place) for obj, place in first.places if obj != held)
    return ManipulationState(rng.choice([what.start, what.locations[0].name]), held, places, marks)


def as_arm(what: ManipulationModel, state: ManipulationState) -> judge.Arm:
    slots = dict(state.slots)
    places = [
        None if obj.name == state.held else (state.place[obj.name], slots.get(obj.name, 0)) for obj in what.objects
    ]
    hand = state.hand if state.hand_slot is None else f"{state.hand}[{state.hand_slot}]"
    return judge.Arm(hand, state.held, tuple(places), state.marks)


def exact_costs(cost: Any) -> tuple[Fraction, ...]:
    return tuple(map(Fraction, cost.values() if isinstance(cost, Mapping) else [cost]))


def assert_judged(what: ManipulationModel, begin: ManipulationState, barred: tuple[frozenset[str], str]) -> None:
    """Fail if a model's transition system, listed or not, is not that of the judge."""
    system = replace(what, begin=begin).transition_system().without([barred])
    table, cell = system.listed, judge.Cell(what)
    large = replace(what, listed_states=0, begin=begin).transition_system().without([barred])
    number = {as_arm(what, state): k for k, state in enumerate(table.states)}  # type: ignore[arg-type]
    first = cell.start(begin)
    assert table.size >= len(number) and number[first] == table.start and as_arm(what, large.start) == first
    queue, seen = deque([(first, large.start)]), {first}
    while queue:
        arm, state = queue.popleft()
        k, label = number[arm], cell.label(arm)
        steps = [step for step in cell.steps(arm) if not (barred[0] <= label and step[0] == barred[1])]
        edges = table.edges(k)
        assert table.label(k) == large.label(state) == label
        assert [table.action_names[table.actions[edge]] for edge in edges] == [action for action, *_ in steps]
        assert [table.targets[edge] for edge in edges] == [number[after] for *_, after in steps]
        for edge, (action, cost, after) in zip(edges, steps, strict=True):
            reached, costs = large.steps(state, action)
            assert costs == tuple(int(each.entries[edge]) * each.unit for each in table.costs) == exact_costs(cost)
            assert as_arm(what, reached) == after
            if after not in seen:
                seen.add(after)
                queue.append((after, reached))


@pytest.mark.parametrize("seed", range(24))
def test_random_models_agree_with_a_plain_walk_over_the_states(seed: int) -> None:
    rng = random.Random(seed)
    what = random_model(rng)
    system = what.transition_system()
    assert_judged(what, what.initial_state, (frozenset(), "transit nowhere"))
    number = {as_arm(what, state): k for k, state in enumerate(system.listed.states)}  # type: ignore[arg-type]
    assert len(number) == system.listed.size


@pytest.mark.parametrize("seed", range(24))
def test_random_costs_slots_and_starts_agree_with_a_plain_walk_over_the_states(seed: int) -> None:
    rng = random.Random(100 + seed)
    what = with_costs(rng, random_model(rng))
    barred = frozenset(rng.sample(sorted(what.own_propositions), 1)), f"transit {what.locations[0].name}"
    assert_judged(what, random_start(rng, what), barred)
