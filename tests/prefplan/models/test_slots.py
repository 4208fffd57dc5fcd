"""Slots of locations that hold several objects."""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from typing import NamedTuple

import judge
import pytest
from small_models import COSTS, measured

from prefplan import ManipulationModel, ManipulationState, ModelError, Planner, Problem, Task, pareto_front
from prefplan.models.manipulation.action_costs import MeasuredCosts, Pair
from prefplan.models.manipulation.model import Location, Object
from prefplan.models.manipulation.slots import free_slot, hand_poses, location_of, pose, slots_at_start
from prefplan.preferences.kinds import Order
from prefplan.product.reduction import GeneratedProduct


@pytest.mark.parametrize(
    ("taken", "slot"),
    [("--", 0), ("x-", 1), ("-x", 0), ("---", 0), ("x--", 2), ("--x", 0), ("-x-", 0), ("x-x", 1), ("x---", 2)],
)
def test_an_object_is_put_where_the_others_are_far(taken: str, slot: int) -> None:
    occupied = [k for k, letter in enumerate(taken) if letter == "x"]
    assert free_slot(occupied, 0, len(taken)) == slot
    # Slots of other locations do not matter.
    assert free_slot([1, *(3 + k for k in occupied), 3 + len(taken)], 3, 3 + len(taken)) == 3 + slot


def test_objects_fill_slots_in_order_around_those_whose_slots_are_known() -> None:
    places = [("a", "tray"), ("b", "tray"), ("c", "desk"), ("d", "tray")]
    capacities = {"tray": 3, "desk": 1}
    assert slots_at_start(places, {}, capacities) == {"a": 0, "b": 1, "c": 0, "d": 2}
    assert slots_at_start(places, {"d": 0}, capacities) == {"a": 1, "b": 2, "c": 0, "d": 0}
    with pytest.raises(ModelError, match="start: no room for 'd' at 'tray', which has room for 2"):
        slots_at_start(places, {}, {"tray": 2, "desk": 1})


def test_the_hand_is_over_a_slot_the_middle_or_where_it_starts() -> None:
    assert hand_poses({"a": 1, "b": 2}, "home") == ("a", "b", "b[0]", "b[1]", "home")
    assert hand_poses({"a": 1, "b": 1}, "b") == ("a", "b")
    assert [location_of(name) for name in ("a", pose("b", 1), pose("b", None))] == ["a", "b", "b"]


@pytest.fixture
def shelf() -> ManipulationModel:
    places = (Location("desk", at=(0.4, 0)), Location("shelf", at=(0.4, 0.3), capacity=2))
    return ManipulationModel("home", MeasuredCosts("time"), places, (Object("cup", "shelf"), Object("jug", "desk")))


def test_states_tell_slots_where_costs_are_measured(shelf: ManipulationModel) -> None:
    system = measured(shelf).transition_system().listed
    state, slots = system.start, []
    for action in ("transit desk", "grasp jug", "transport jug shelf", "release jug shelf", "grasp cup"):
        state, _ = system.step(state, action)
        found = system.states[state]
        assert isinstance(found, ManipulationState)
        slots.append((found.hand_slot, dict(found.slots)))
    assert slots == [
        (None, {"cup": 0}),
        (None, {"cup": 0}),
        (1, {"cup": 0}),
        (1, {"cup": 0, "jug": 1}),
        (0, {"jug": 1}),
    ]
    assert len(set(system.states)) == system.size
    assert len(set(system.label_sets)) == len(system.label_sets)


def test_slots_that_are_known_at_the_start_are_begun_with(shelf: ManipulationModel) -> None:
    places = (("cup", "shelf"), ("jug", "desk"))
    start = ManipulationState("home", None, places, slots=(("cup", 1),))
    system = replace(measured(shelf), begin=start).transition_system().listed
    assert system.states[system.start] == start


def test_numbers_for_costs_need_no_slots(shelf: ManipulationModel) -> None:
    costs = {"transit": 3, "grasp": 1, "transport": 5, "release": 1}
    plain = ManipulationModel("home", costs, shelf.locations, shelf.objects).transition_system().listed
    states = {(state.hand, state.held, state.places) for state in measured(shelf).transition_system().listed.states}
    assert {(state.hand, state.held, state.places) for state in plain.states} == states
    assert plain.size == len(states) < measured(shelf).transition_system().listed.size
    assert all(state.slots == () and state.hand_slot is None for state in plain.states)


@dataclass(frozen=True)
class Spot:
    """A state spelled out: the hand's pose, what it holds, and the location and slot of all else."""

    hand: str
    held: str | None
    lying: frozenset[tuple[str, str, int]]


class Walk(NamedTuple):
    """The result of an enumeration of all states."""

    edges: tuple[judge.Edge, ...]
    labels: dict[str, frozenset[str]]


def spelled_out(entries: dict[Pair, Decimal], lying: set[tuple[str, str, int]], capacities: dict[str, int]) -> Walk:
    """Return every state and edge of a model whose slots are followed one action at a time."""

    def over(place: str, slot: int) -> str:
        return f"{place}[{slot}]" if capacities[place] > 1 else place

    def steps(at: Spot) -> Iterator[tuple[str, Spot]]:
        here = at.hand.split("[")[0]
        for place in capacities if at.held is None else ():
            if place != here:
                yield f"transit {place}", Spot(place, None, at.lying)
        for obj, place, slot in at.lying if at.held is None else ():
            if place == here:
                yield f"grasp {obj}", Spot(over(place, slot), obj, at.lying - {(obj, place, slot)})
        for place in capacities if at.held is not None else ():
            taken = {slot for _, other, slot in at.lying if other == place}
            free = [slot for slot in range(capacities[place]) if slot not in taken]
            if free:
                # Two slots off is as good as any; the first of those that are as good.
                slot = min(free, key=lambda i: (-min([2, *(abs(i - j) for j in taken)]), i))
                if place != here:
                    yield f"transport {at.held} {place}", Spot(over(place, slot), at.held, at.lying)
                else:
                    yield (
                        f"release {at.held} {place}",
                        Spot(over(place, slot), None, at.lying | {(at.held, place, slot)}),
                    )

    first = Spot("home", None, frozenset(lying))
    names, queue, edges = {first: "0"}, deque([first]), []
    while queue:
        at = queue.popleft()
        for action, after in steps(at):
            if after not in names:
                names[after] = f"{len(names)}"
                queue.append(after)
            cost = Fraction(entries[action.split()[0], at.hand, after.hand])
            edges.append(judge.Edge(names[at], action, cost, names[after]))
    labels = {name: frozenset(f"{obj}_{place}" for obj, place, _ in at.lying) for at, name in names.items()}
    return Walk(tuple(edges), labels)


@pytest.mark.parametrize("capacity", [2, 3])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_fronts_are_exact_where_slots_are_told_apart(seed: int, capacity: int) -> None:
    capacities = {"desk": 1, "shelf": capacity, "box": 1}
    rng, hands = random.Random(seed), hand_poses(capacities, "home")
    entries = {(k, a, b): Decimal(rng.randint(500, 9999)).scaleb(-3) for k in COSTS for a in hands for b in hands}
    places = tuple(Location(name, at=(0.4, 0.0), capacity=number) for name, number in capacities.items())
    objects = (Object("cup", "shelf"), Object("pot", "shelf"))
    model = ManipulationModel("home", MeasuredCosts("time", entries), places, objects)
    system = model.transition_system().listed
    lying = {("cup", "shelf", 0), ("pot", "shelf", 1)}
    walk = spelled_out(entries, lying, capacities)
    assert (system.size, len(system.targets)) == (len(walk.labels), len(walk.edges))
    tasks = [Task("cup", "F (cup_desk & F cup_shelf)"), Task("pot", "F (pot_box & F pot_shelf)")]
    rng.shuffle(tasks)
    judged_tasks = tuple(judge.JudgedTask(task.name, judge.parse(task.formula)) for task in tasks)
    see = judge.GraphProblem("0", walk.edges, walk.labels, judged_tasks)
    listed = pareto_front(Problem(system, tasks, Order()))
    expected = judge.exact_front(see, max_cost=judge.exact(listed[-1].cost) + Fraction(1, 2))
    planner = Planner(Problem(replace(model, listed_states=0).transition_system(), tasks, Order()))
    for front in (listed, planner.front()):
        assert [(judge.exact(plan.cost), judge.exact(plan.preference)) for plan in front] == expected
        for plan in front:
            assert judge.replay(see, plan.actions).cost == judge.exact(plan.cost)
    assert isinstance(planner._product, GeneratedProduct)
