"""Random manipulation problems with a handful of objects, most of whose locations are alike."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import judge
from small_models import COSTS

from prefplan import (
    Deadline,
    Due,
    Expression,
    Location,
    ManipulationModel,
    NamedPreference,
    Object,
    Order,
    Preference,
    Problem,
    Relaxation,
    Task,
    TransitionSystem,
    WeightedSum,
)
from prefplan.models.manipulation.action_costs import MeasuredCosts
from prefplan.models.manipulation.slots import hand_poses
from prefplan.models.manipulation.symbolic import at


def random_model(rng: random.Random, *, large: bool = False) -> ManipulationModel:
    """Draw a model of 4 to 6 locations, most of them alike, and 2 to 4 objects."""
    names = [f"l{k}" for k in range(rng.randint(4, 6))]
    places = []
    for k, name in enumerate(names):
        on = (rng.choice(names[:k]),) if k and rng.random() < 0.15 else ()
        marks, capacity = rng.choice((None, None, "wet")), rng.choice((1, 1, 1, 2))
        places.append(Location(name, at=None if on else (0.0, 0.0), on=on, marks=marks, capacity=capacity))
    flat = [place.name for place in places if not place.on]
    starts = rng.sample(flat, min(len(flat), rng.randint(2, 4)))
    objects = [Object(f"o{k}", start, fixed=rng.random() < 0.1) for k, start in enumerate(starts)]
    rng.shuffle(places)
    model = ManipulationModel(rng.choice(["home", *names]), COSTS, tuple(places), tuple(objects))
    return replace(model, listed_states=0) if large else model


def random_measured(rng: random.Random, model: ManipulationModel, measured: str | tuple[str, ...]) -> ManipulationModel:
    """Draw measured costs between every two poses of the hand in a model; in half of them some cannot be measured."""
    places = model.locations
    hands = hand_poses({place.name: place.capacity for place in places}, model.start)
    quantities = measured if isinstance(measured, tuple) else ()
    entries = {
        (kind, before, after): {name: rng.randint(0, 9) for name in quantities} or rng.randint(0, 9)
        for kind in COSTS
        for before in hands
        for after in hands
    }
    gaps = random.Random(str(entries))
    failed = gaps.sample([*entries], gaps.choice([0, len(entries) // 12]))
    left = {pair: cost for pair, cost in entries.items() if pair not in failed}
    return replace(model, costs=MeasuredCosts(measured, left, dict.fromkeys(failed, "a wall")))


def random_problem(rng: random.Random, *, measured: bool = False, large: bool = False) -> Problem:
    """Draw one to three tasks over a few propositions of a random model, and a preference.

    The model counts as one of too many states to list if it is to be `large`.
    """
    model = random_model(rng, large=large)
    if measured:
        model = random_measured(rng, model, "time")
    tasks, preferences = _random_tasks(rng, model)
    return Problem(model.transition_system(), tasks, rng.choice(preferences))


def random_several(rng: random.Random, *, measured: bool = False, large: bool = False) -> Problem:
    """Draw the same with two costs, and one or two preferences, each of either cost."""
    model = random_model(rng, large=large)
    costs = {kind: {name: rng.randint(0, 6) for name in ("time", "energy")} for kind in COSTS}
    model = random_measured(rng, model, ("time", "energy")) if measured else replace(model, costs=costs)
    tasks, preferences = _random_tasks(rng, model)
    chosen = rng.sample(preferences, min(len(preferences), rng.randint(1, 2)))
    named = [NamedPreference(f"p{k}", one, rng.choice((None, "energy"))) for k, one in enumerate(chosen)]
    return Problem(model.transition_system(), tasks, named)


def _random_tasks(rng: random.Random, model: ManipulationModel) -> tuple[list[Task], list[Preference]]:
    """Draw tasks, and return preferences that fit them."""
    names = sorted(rng.sample(sorted(model.own_propositions), 3))
    forms = (
        "F {0}",
        "F ({0} & F {1})",
        "F ({0} & {1})",
        "!{0} U {1}",
        "F ({0} & X {1})",
        "F (!{0} & X X {1})",
        "X {0}",
    )
    tasks = []
    for k in range(rng.randint(1, 3)):
        rng.shuffle(names)
        relax = (Relaxation(names[0], f"!{names[2]}", rng.randint(1, 9)),) if rng.random() < 0.2 else ()
        tasks.append(Task(f"t{k}", rng.choice(forms).format(*names), relax=relax, skip=rng.choice((None, None, 5))))
    bought = any(task.relax or task.skip is not None for task in tasks)
    ids = [task.name for task in tasks]
    free: list[Preference] = [
        Order(),
        WeightedSum({name: rng.randint(0, 3) for name in ids}),
        Deadline({ids[0]: Due(by=10, weight=1)}),
        Expression(" * ".join(ids), contract="componentwise"),
    ]
    paid = WeightedSum({name: rng.randint(1, 3) for name in ids}, over="violation")
    return tasks, [paid] if bought else free


def enumerated(model: ManipulationModel, exists: Callable[[str, str, frozenset[str]], bool]) -> TransitionSystem:
    """Return the states that the judge reaches by actions that exist, each with where what is held was grasped.

    `exists` is asked about an action, where the object in the hand was grasped, "" if none is, and the label before.
    """
    cell, places = judge.Cell(model), [place.name for place in model.locations]

    @cache
    def seen(arm: judge.Arm) -> tuple[frozenset[str], list[tuple[str, str, judge.Arm, Any]]]:
        """Return the label of a state, and its actions, each with where it grasps, the state after it and its cost."""
        label, steps = cell.label(arm), list[tuple[str, str, judge.Arm, Any]]()
        for text, cost, after in cell.steps(arm):
            kind, obj, *_ = text.split()
            here = next(place for place in places if at(obj, place) in label) if kind == "grasp" else ""
            steps.append((text, here, after, cost))
        return label, steps

    start = (cell.start(model.initial_state), "")
    number, pending, transitions = {start: 0}, [start], []
    for arm, origin in pending:
        label, steps = seen(arm)
        for text, here, after, cost in steps:
            if exists(text, origin, label):
                reached = after, here or (origin if after.held else "")
                if reached not in number:
                    number[reached] = len(number)
                    pending.append(reached)
                transitions.append((number[arm, origin], text, number[reached], cost))
    return TransitionSystem.from_transitions(
        transitions,
        start=0,
        labels={k: seen(arm)[0] for (arm, _), k in number.items()},
        propositions=model.valid_propositions,
    )
