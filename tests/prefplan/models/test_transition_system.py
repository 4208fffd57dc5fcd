"""Weighted transition systems (Definition 1): from transitions, from and to networkx, and refused input."""

from __future__ import annotations

import random
from decimal import Decimal
from fractions import Fraction

import networkx as nx
import numpy as np
import pytest

from prefplan import ModelError, TransitionSystem

TRANSITIONS = [
    ("home", "east", "field", 1),
    ("home", "north", "hill", 2.5),
    ("field", "north", "hill", 0),
    ("hill", "stay", "hill", 3),
]


@pytest.fixture
def farm() -> TransitionSystem:
    return TransitionSystem.from_transitions(
        TRANSITIONS,
        start="home",
        labels={"field": ["plant", "dirt"], "hill": {"rock"}},
        propositions=["water"],
    )


def described(system: TransitionSystem) -> dict:
    """Return a system as plain data: by state its label and its (action, target, cost), in order."""
    found = {}
    for state in range(system.size):
        actions = [system.action_names[system.actions[edge]] for edge in system.edges(state)]
        ends = [system.step(state, action) for action in actions]
        edges = [(action, system.states[target], cost) for action, (target, cost) in zip(actions, ends, strict=True)]
        found[system.states[state]] = (system.label(state), edges)
    return found


def test_transitions_become_states_actions_costs_and_labels(farm: TransitionSystem) -> None:
    assert described(farm) == {
        "home": (frozenset(), [("east", "field", 1), ("north", "hill", 2.5)]),
        "field": (frozenset({"plant", "dirt"}), [("north", "hill", 0)]),
        "hill": (frozenset({"rock"}), [("stay", "hill", 3)]),
    }
    assert farm.states[farm.start] == "home"
    assert farm.propositions == {"plant", "dirt", "rock", "water"}


def test_arrays_have_the_documented_shapes_and_types(farm: TransitionSystem) -> None:
    assert (farm.offsets.shape, farm.offsets.dtype) == ((4,), np.int64)
    assert (farm.targets.shape, farm.targets.dtype) == ((4,), np.int32)
    assert (farm.actions.shape, farm.actions.dtype) == ((4,), np.int32)
    costs = farm.costs[0]
    assert (costs.entries.tolist(), costs.entries.dtype, costs.unit) == ([2, 5, 0, 6], np.int64, Fraction(1, 2))
    assert (farm.labels.shape, farm.labels.dtype) == ((3,), np.int32)


def test_an_action_may_have_several_costs_by_name() -> None:
    transitions = [("b", "go", "a", {"time": 2, "toll": 0.5}), ("a", "go", "b", {"time": 4, "toll": 0})]
    system = TransitionSystem.from_transitions(transitions, start="a")
    assert system.cost_names == ("time", "toll")
    steps = {system.states[state]: system.steps(state, "go")[1] for state in range(2)}
    assert steps == {"b": (2, Fraction(1, 2)), "a": (4, 0)}


def test_an_action_that_does_not_exist_there_is_an_error(farm: TransitionSystem) -> None:
    with pytest.raises(ModelError, match="action 'stay' does not exist in state 'home'"):
        farm.step(farm.start, "stay")


@pytest.mark.parametrize(
    ("transitions", "options", "message"),
    [
        ([("a", "go", "b", -1)], {}, "action 'go' from state 'a': negative cost -1"),
        ([("a", "go", "b", -0.5)], {}, "action 'go' from state 'a': negative cost -0.5"),
        ([("a", "go", "b", 1), ("a", "go", "c", 1)], {}, "action 'go' leaves state 'a' twice"),
        ([("a", "go", "b", 1)], {"labels": {"c": ["p"]}}, "label on unknown state 'c'"),
        ([("a", "go", "b", 1)], {"labels": {"b": ["2p"]}}, "propositions: '2p' is not a name"),
        ([("a", "go", "b", 1)], {"labels": {"b": ["p q"]}}, "propositions: 'p q' is not a name"),
        ([("a", "go", "b", 1)], {"labels": {"b": ["U"]}}, "propositions: 'U' is a reserved word"),
        ([("a", "go", "b", 1)], {"propositions": ["true"]}, "propositions: 'true' is a reserved word"),
        ([("a", "go", "b", 1)], {"labels": {"b": "plant"}}, "must be a list such as ['plant'], not"),
        ([("a", "go", "b", float("inf"))], {}, "must be a finite number"),
        ([("a", "go", "b", Decimal("nan"))], {}, "must be a finite number"),
        ([("a", "go", "b", "3")], {}, "must be a number"),
        ([("a", "go", "b", [1])], {}, "action 'go' from state 'a': must be a number, not [1]"),
        (
            [("a", "go", "b", 1), ("b", "go", "a", {"time": 1})],
            {},
            "action 'go' from state 'b': gives the costs time, but action 'go' from state 'a' gives a number",
        ),
        ([("a", "go", "b", {"time": -1})], {}, "action 'go' from state 'a'.time: negative cost -1"),
        ([("a", "go", "b", Decimal("1e999"))], {}, "action 'go' from state 'a': must be 0 or lie between"),
    ],
)
def test_what_makes_no_sense_is_refused(transitions: list, options: dict, message: str) -> None:
    with pytest.raises(ModelError) as caught:
        TransitionSystem.from_transitions(transitions, start="a", **options)
    assert message in str(caught.value)


def test_a_networkx_graph_becomes_a_system() -> None:
    graph = nx.DiGraph()
    graph.add_node("s0")
    graph.add_node("s1", labels=["plant"])
    graph.add_edge("s0", "s1", action="east", cost=2)
    graph.add_edge("s1", "s0")
    system = TransitionSystem.from_networkx(graph, start="s0", propositions=["rock"])
    assert described(system) == {
        "s0": (frozenset(), [("east", "s1", 2)]),
        "s1": (frozenset({"plant"}), [("s0", "s0", 1)]),
    }
    assert system.propositions == {"plant", "rock"}


@pytest.mark.parametrize(
    ("graph", "message"),
    [
        (nx.DiGraph([("z", "b")]), "start 'a' is not a node of the graph"),
        (nx.MultiDiGraph([("a", "b"), ("a", "b")]), "action 'b' leaves state 'a' twice"),
    ],
)
def test_a_networkx_graph_that_is_no_system_is_refused(graph: nx.Graph, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        TransitionSystem.from_networkx(graph, start="a")


def test_parallel_edges_of_a_multigraph_are_kept_apart_by_their_actions() -> None:
    graph = nx.MultiDiGraph()
    graph.add_edge(0, 1, action="walk", cost=4)
    graph.add_edge(0, 1, action="drive", cost=1)
    system = TransitionSystem.from_networkx(graph, start=0)
    assert (system.step(0, "walk")[1], system.step(0, "drive")[1]) == (4, 1)


@pytest.mark.parametrize("seed", range(20))
def test_a_system_survives_networkx_and_back(seed: int) -> None:
    rng = random.Random(seed)
    size = rng.randint(1, 8)
    transitions = [
        (s, f"a{k}", rng.randrange(size), rng.choice((0, 1, 0.25, 7)))
        for s in range(size)
        for k in range(rng.randint(0, 4))
    ]
    states = {0} | {s for t in transitions for s in (t[0], t[2])}
    labels = {s: rng.sample("pqr", rng.randint(0, 3)) for s in states}
    system = TransitionSystem.from_transitions(transitions, start=0, labels=labels)
    graph = system.to_networkx()  # which keeps the actions to one target together, not in the model's order
    assert (graph.number_of_nodes(), graph.number_of_edges()) == (system.size, len(transitions))
    again = TransitionSystem.from_networkx(graph, start=graph.graph["start"])
    assert {state: (label, sorted(edges)) for state, (label, edges) in described(again).items()} == {
        state: (label, sorted(edges)) for state, (label, edges) in described(system).items()
    }
    assert again.propositions == system.propositions


def test_an_undirected_edge_of_a_graph_leads_both_ways() -> None:
    graph = nx.Graph()
    graph.add_edge("a", "b", cost=3)
    system = TransitionSystem.from_networkx(graph, start="a")
    assert [system.step(0, "b"), system.step(1, "a")] == [(1, 3), (0, 3)]
