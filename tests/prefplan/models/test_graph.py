"""The explicit graph model."""

from __future__ import annotations

import pytest

from prefplan import ModelError
from prefplan.models.graph import GraphModel, Transition


def test_an_action_left_out_is_named_after_its_target() -> None:
    system = GraphModel("s0", (Transition("s0", "s1"), Transition("s0", "s2", "jump", 4))).transition_system()
    assert [system.action_names[system.actions[edge]] for edge in system.edges(0)] == ["s1", "jump"]
    assert [system.step(0, action)[1] for action in ("s1", "jump")] == [1, 4]


def test_labels_and_declared_propositions_may_be_used() -> None:
    model = GraphModel("s0", (Transition("s0", "s1"),), {"s1": ["plant", "dirt"]}, frozenset({"rock"}))
    system = model.transition_system()
    assert system.label(system.step(0, "s1")[0]) == {"plant", "dirt"}
    assert system.propositions == {"plant", "dirt", "rock"}


@pytest.mark.parametrize(
    ("transitions", "labels", "message"),
    [
        ([("s0", "s1", "go", 1), ("s0", "s2", "go", 1)], {}, "transitions[1]: action 'go' leaves state 's0' twice"),
        ([("s0", "s1", None, 1), ("s0", "s2", "s1", 1)], {}, "transitions[1]: action 's1' leaves state 's0' twice"),
        ([("s0", "s1", None, 1), ("s1", "s0", None, -2)], {}, "transitions[1].cost: negative cost -2"),
        ([("s1", "s2", None, 1)], {}, "start: unknown state 's0' (valid: s1, s2)"),
        ([("s0", "s1", None, 1)], {"s2": ["p"]}, "labels: unknown state 's2' (valid: s0, s1)"),
        ([("s0", "kitchen", None, 1)], {"kitchne": ["p"]}, "labels: unknown state 'kitchne' (did you mean 'kitchen'?)"),
        ([("s0", "s1", None, 1)], {"zzz": ["p"]}, "labels: unknown state 'zzz' (valid: s0, s1)"),
    ],
)
def test_what_makes_no_sense_is_refused(transitions: list, labels: dict, message: str) -> None:
    with pytest.raises(ModelError) as caught:
        GraphModel("s0", tuple(Transition(*edge) for edge in transitions), labels)
    assert str(caught.value) == message
