"""Operators state by state and many states at once; user-defined operators; actions and their texts."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace

import pytest
from small_models import COSTS, TOWER, measured, model, spot

from prefplan import (
    STANDARD_OPERATORS,
    Action,
    ManipulationModel,
    ManipulationState,
    ModelError,
    Object,
    Operator,
    TransitionSystem,
)
from prefplan.models.manipulation.operators import Outcomes

CROWDED = model(
    Object("cup", "a"),
    Object("jug", "b", fixed=True),
    Object("pot", "box"),
    locations=[spot("a"), spot("b", marks="clean"), spot("box", capacity=2), spot("c", clear_of=("b",), closed=True)],
)


class Statewise(Operator):
    """A standard operator, asked one state at a time."""

    def __init__(self, operator: Operator) -> None:
        self.kind, self._operator = operator.kind, operator  # type: ignore[misc]

    def outcomes(self, model: ManipulationModel, state: ManipulationState) -> Outcomes:
        return self._operator.outcomes(model, state)


def described(system: TransitionSystem) -> dict[Hashable, list[tuple[str, Hashable, int | float]]]:
    """Return the actions of each state in order, each with its successor and its cost."""
    return {
        name: [
            (system.action_names[system.actions[e]], system.states[system.targets[e]], system.cost(e))
            for e in system.edges(state)
        ]
        for state, name in enumerate(system.states)
    }


@pytest.mark.parametrize("what", [TOWER, CROWDED, measured(CROWDED)], ids=["tower", "crowded", "slots"])
def test_state_by_state_is_the_same_as_many_at_once(what: ManipulationModel) -> None:
    fast = what.transition_system().listed
    slow = replace(what, operators=tuple(map(Statewise, what.operators))).transition_system().listed
    assert described(fast) == described(slow)
    labels = [{name: system.label(state) for state, name in enumerate(system.states)} for system in (fast, slow)]
    assert labels[0] == labels[1] and fast.states[fast.start] == slow.states[slow.start]


class Swap(Operator):
    """Exchange the locations of the first two objects, whether or not that gives a valid state."""

    kind, parameters = "swap", ("obj",)

    def __init__(self, to: Sequence[str] = (), kind: str = "swap") -> None:
        self.to, self.told = to, kind

    def outcomes(self, model: ManipulationModel, state: ManipulationState) -> Outcomes:
        if state.held is None:
            (one, here), (other, there), *rest = state.places
            places = dict(zip((one, other), self.to or (there, here), strict=True)) | dict(rest)
            yield Action(self.told, one), replace(state, places=tuple(places.items()))


def with_swap(swap: Swap) -> ManipulationModel:
    operators = (*STANDARD_OPERATORS, swap)
    return replace(model(Object("cup", "a"), Object("jug", "b")), costs={**COSTS, "swap": 2}, operators=operators)


def test_an_operator_of_ones_own_has_its_actions_after_the_others() -> None:
    what = with_swap(Swap())
    system = what.transition_system().listed
    first = [system.action_names[system.actions[edge]] for edge in system.edges(system.start)]
    assert first == ["transit a", "transit b", "transit c", "swap cup"]
    state, cost = system.step(system.start, "swap cup")
    assert (dict(system.states[state].places), cost) == ({"cup": "b", "jug": "a"}, 2)  # type: ignore[attr-defined]
    assert what.action("swap cup") == Action("swap", "cup")


@pytest.mark.parametrize(
    ("swap", "message"),
    [
        (Swap(to=("d", "a")), "after `swap cup`: 'cup' at unknown location 'd' (valid: a, b, c)"),
        (Swap(kind="grasp"), "operator 'swap' yields `grasp cup`, an action of another kind"),
    ],
)
def test_an_outcome_that_does_not_fit_the_model_is_refused(swap: Swap, message: str) -> None:
    with pytest.raises(ModelError) as caught:
        _ = with_swap(swap).transition_system().listed
    assert str(caught.value) == message


def test_every_kind_is_there_once_and_has_a_cost() -> None:
    with pytest.raises(ModelError, match="operators: 'swap' is listed twice"):
        replace(with_swap(Swap()), operators=(Swap(), Swap()))
    with pytest.raises(ModelError, match="costs: no cost for 'swap'"):
        replace(with_swap(Swap()), costs=COSTS)


@pytest.mark.parametrize(
    "action", [Action("transit", location="a"), Action("grasp", "cup"), Action("release", "cup", "a")]
)
def test_the_text_of_an_action_means_that_action(action: Action) -> None:
    assert TOWER.action(str(action)) == action


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "unknown action '' (valid: transit, grasp, transport, release)"),
        ("graps cup", "unknown action 'graps' (did you mean 'grasp'?)"),
        ("release cup", "action 'release cup': is written 'RELEASE OBJ LOCATION'"),
    ],
)
def test_a_text_that_means_no_action_is_refused(text: str, message: str) -> None:
    with pytest.raises(ModelError) as caught:
        TOWER.action(text)
    assert str(caught.value) == message
