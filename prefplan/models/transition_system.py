"""Weighted transition systems (Definition 1) as arrays, for up to 10^6 states and more, and their construction."""

from __future__ import annotations

import sys
from collections.abc import Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, runtime_checkable

import numpy as np

from prefplan.errors import ModelError, choices, describe
from prefplan.exact_costs import Number, in_units, to_number
from prefplan.models.costs import DEFAULT_COST, Cost, CostTable, by_name, check_costs_agree
from prefplan.models.system import System
from prefplan.text.names import check_names

if TYPE_CHECKING:
    import networkx as nx


@dataclass(frozen=True, kw_only=True)
class TransitionSystem(System):
    """A weighted transition system (Definition 1) whose states are listed; see also the attributes of `System`.

    States are 0 .. S-1; the actions of state s are the edges `offsets[s]:offsets[s + 1]`, in the model's order.

    Attributes:
        states: (S,) the name of each state in plans; any sequence, so that names may be computed on demand.
        start: index of s0.
        offsets: (S + 1,) int64.
        targets: (E,) int32, state that each edge leads to.
        actions: (E,) int32, index into `action_names`.
        labels: (S,) int32, index into `label_sets`.
        action_names: names of the actions.
        label_sets: distinct sets of propositions; a state's label is one of them.
    """

    states: Sequence[Hashable]
    start: int
    offsets: np.ndarray
    targets: np.ndarray
    actions: np.ndarray
    labels: np.ndarray
    action_names: tuple[str, ...]
    label_sets: tuple[frozenset[str], ...]

    @property
    def size(self) -> int:
        """Number of states."""
        return len(self.offsets) - 1

    @property
    def most_states(self) -> int:
        """Number of states."""
        return self.size

    @property
    def listed(self) -> TransitionSystem:
        """This system."""
        return self

    @property
    def small(self) -> TransitionSystem:
        """This system."""
        return self

    def decode(self, state: int) -> Hashable:
        """See `System.decode`."""
        return self.states[state]

    def label(self, state: int) -> frozenset[str]:
        """See `System.label`."""
        return self.label_sets[self.labels[state]]

    def edges(self, state: int) -> range:
        """Return the indices of the edges that leave a state, in the model's action order."""
        return range(self.offsets[state], self.offsets[state + 1])

    def cost(self, edge: int) -> Number:
        """Return the first cost of an edge, in the user's units."""
        return to_number(int(self.costs[0].entries[edge]) * self.costs[0].unit)

    def steps(self, state: int, action: str) -> tuple[int, tuple[Fraction, ...]]:
        """See `System.steps`."""
        for edge in self.edges(state):
            if self.action_names[self.actions[edge]] == action:
                return int(self.targets[edge]), tuple(int(each.entries[edge]) * each.unit for each in self.costs)
        raise ModelError(f"action {action!r} does not exist in state {self.states[state]!r}")

    @classmethod
    def from_transitions(
        cls,
        transitions: Iterable[tuple[Hashable, str, Hashable, Cost]],
        *,
        start: Hashable,
        labels: Mapping[Any, Iterable[str]] | None = None,
        propositions: Iterable[str] = (),
    ) -> TransitionSystem:
        """Build a system from (source, action, target, cost) tuples; the order of a state's actions is kept.

        Args:
            transitions: every edge; states are created as they are named. A cost is a number, or several by name.
            start: the initial state, which may have no edge.
            labels: propositions true in a state; states not listed have none.
            propositions: further names that formulas may use, although they hold in no state.

        Raises:
            ModelError: a cost is negative or has other names than the first, an action leaves a state twice, a label
                is of an unknown state, or a proposition is not a valid name.
        """
        index: dict[Hashable, int] = {start: 0}
        action_index: dict[str, int] = {}
        edges: dict[tuple[int, int], int] = {}
        costs: list[tuple[str, Cost]] = []
        for i, transition in enumerate(transitions):
            try:
                source, action, target, cost = transition
            except (TypeError, ValueError):
                what = f"must be (source, action, target, cost), not {describe(transition)}"
                raise ModelError(f"transitions[{i}]: {what}") from None
            s, t = index.setdefault(source, len(index)), index.setdefault(target, len(index))
            edge = s, action_index.setdefault(action, len(action_index))
            if edge in edges:
                raise ModelError(f"action {action!r} leaves state {source!r} twice")
            edges[edge] = t
            costs.append((f"action {action!r} from state {source!r}", cost))
        check_costs_agree(costs)
        names = tuple(by_name(costs[0][1])) if costs else (DEFAULT_COST,)
        sources, actions = np.array(list(edges), dtype=np.int64).reshape(-1, 2).T
        return cls.from_arrays(
            states=tuple(index),
            start=0,
            sources=sources,
            targets=np.array(list(edges.values()), dtype=np.int64),
            actions=actions,
            costs={name: [by_name(cost)[name] for _, cost in costs] for name in names},
            action_names=tuple(action_index),
            label_of={index[state]: label for state, label in _labels(labels or {}, index).items()},
            propositions=propositions,
        )

    @classmethod
    def from_arrays(
        cls,
        *,
        states: Sequence[Hashable],
        start: int,
        sources: np.ndarray,
        targets: np.ndarray,
        actions: np.ndarray,
        costs: Mapping[str, Sequence[Number]],
        action_names: tuple[str, ...],
        label_of: Mapping[int, frozenset[str]],
        propositions: Iterable[str] = (),
    ) -> TransitionSystem:
        """Build a system from checked edges in any order; the order of a state's actions is kept.

        Arguments are named as the attributes; `sources` are the (E,) states that the edges leave, `costs` are by name
        and in the user's units, `label_of` is by state.

        Raises:
            ModelError: a proposition is not a valid name.
        """
        propositions = frozenset(propositions).union(*label_of.values())
        check_names(propositions, where="propositions")
        order = np.argsort(sources, kind="stable")
        columns = {name: in_units(each) for name, each in costs.items()}
        distinct = {names: i for i, names in enumerate(dict.fromkeys([frozenset[str](), *label_of.values()]))}
        labels = np.zeros(len(states), dtype=np.int32)
        for state, names in label_of.items():
            labels[state] = distinct[names]
        return cls(
            states=states,
            start=start,
            offsets=np.searchsorted(sources[order], np.arange(len(states) + 1)).astype(np.int64),
            targets=targets[order].astype(np.int32),
            actions=actions[order].astype(np.int32),
            costs=tuple(CostTable(name, counts[order], unit) for name, (counts, unit, _) in columns.items()),
            labels=labels,
            action_names=action_names,
            label_sets=tuple(distinct),
            propositions=propositions,
            resolution=max((rounded for _, _, rounded in columns.values() if rounded is not None), default=None),
        )

    @classmethod
    def from_networkx(cls, graph: nx.DiGraph, *, start: Hashable, propositions: Iterable[str] = ()) -> TransitionSystem:
        """Build a system from a networkx graph.

        Undirected edges lead both ways. Nodes may carry `labels` (an iterable of propositions); edges carry `cost` (1
        unless given) and `action` (the target's name unless given). Formulas may also use further `propositions`.

        Raises:
            ModelError: if the start is not a node, an edge has a `weight` in place of a cost, or as in
                `from_transitions`.
        """
        if start not in graph:
            near = f" {choices(start, map(str, graph))}" if isinstance(start, str) else ""
            raise ModelError(f"start {start!r} is not a node of the graph{near}")
        if not graph.is_directed():
            graph = graph.to_directed()
        transitions = []
        for source, target, data in graph.edges(data=True):
            if "weight" in data and "cost" not in data:
                raise ModelError(f"edge {source!r} to {target!r}: has a 'weight' but no 'cost'; name it 'cost'")
            transitions.append((source, str(data.get("action", target)), target, data.get("cost", 1)))
        linked = {start}.union(*graph.edges())
        labels = _labels({node: data.get("labels", ()) for node, data in graph.nodes(data=True)}, graph)
        return cls.from_transitions(
            transitions,
            start=start,
            labels={node: names for node, names in labels.items() if node in linked},
            propositions=frozenset(propositions).union(*labels.values()),
        )

    def to_networkx(self) -> nx.MultiDiGraph:
        """Return the system as a MultiDiGraph with node `labels` (sorted) and edge `action` and `cost`."""
        import networkx as nx  # takes 0.1 s, and few need it

        graph = nx.MultiDiGraph(start=self.states[self.start])
        for state, name in enumerate(self.states):
            graph.add_node(name, labels=sorted(self.label(state)))
            for edge in self.edges(state):
                action = self.action_names[self.actions[edge]]
                graph.add_edge(name, self.states[self.targets[edge]], action=action, cost=self.cost(edge))
        return graph


def _labels(labels: Mapping[Any, Iterable[str]], states: Collection[Hashable]) -> dict[Hashable, frozenset[str]]:
    """Return the propositions of each state that has a label."""
    for state, names in labels.items():
        if state not in states:
            raise ModelError(f"label on unknown state {state!r} {choices(str(state), map(str, states))}")
        if isinstance(names, str):
            raise ModelError(f"label on state {state!r}: must be a list such as [{names!r}], not the string {names!r}")
        if not isinstance(names, Iterable):
            raise ModelError(f"label on state {state!r}: must be a list such as ['p'], not {describe(names)}")
    return {state: frozenset(names) for state, names in labels.items()}


@runtime_checkable
class Model(Protocol):
    """The interface of a model, such as `GridModel`."""

    def transition_system(self) -> System:
        """Return its transition system."""


SystemLike: TypeAlias = "System | Model | nx.Graph"
"""What a user may give for a transition system, see `system_of`."""


def system_of(given: SystemLike, *, start: Hashable | None = None) -> System:
    """Return the transition system that is given as such, as a model, or as a graph for `from_networkx`.

    `start` is a graph's initial node; None for its attribute `start`, which `TransitionSystem.to_networkx` sets.

    Raises:
        ModelError: something else is given, a graph without a start, or a start with anything but a graph.
    """
    # Loading networkx takes 0.1 s; a caller who has a graph has loaded it.
    if (networkx := sys.modules.get("networkx")) is not None and isinstance(given, networkx.Graph):
        first = given.graph.get("start") if start is None else start
        if first is None:
            example = next(iter(given), "a")
            raise ModelError(f"start: missing; it is the graph's initial node, as in Problem(..., start={example!r})")
        return TransitionSystem.from_networkx(given, start=first)
    if start is not None:
        raise ModelError("start: only for a networkx graph; a model or transition system has its own")
    if isinstance(given, System):
        return given
    if isinstance(given, Model) and not isinstance(given, type):
        return given.transition_system()
    raise ModelError(
        f"system: must be a TransitionSystem, a model such as GridModel, or a networkx graph, not {describe(given)}"
    )
