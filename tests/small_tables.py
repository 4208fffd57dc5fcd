"""Manipulation models of few locations, and what can be done there."""

from __future__ import annotations

from typing import Any

from prefplan import Location, ManipulationModel, Object, TransitionSystem

COSTS = {"transit": 3, "grasp": 1, "transport": 5, "release": 1}


TOWER = ManipulationModel(
    start="home",
    costs=COSTS,
    locations=(Location("a", at=(0.5, 0.0)), Location("b", on=("a",)), Location("c", on=("b",))),
    objects=(Object("one", "a"), Object("two", "b"), Object("three", "c")),
)
"""Three cubes, one upon another."""


def model(
    *objects: Object, locations: list[Location] | None = None, start: str = "home", propositions: tuple[str, ...] = ()
) -> ManipulationModel:
    """Return a model with spots a, b, c unless other locations are given."""
    spots = locations or [Location(name, at=(0.4, 0.1 * k)) for k, name in enumerate("abc")]
    return ManipulationModel(start, COSTS, tuple(spots), objects, frozenset(propositions))


def spot(name: str, **options: Any) -> Location:
    return Location(name, at=(0.5, 0.0), **options)


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
