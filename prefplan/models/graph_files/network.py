"""The nodes and edges of a graph file, as arrays."""

from __future__ import annotations

import math
import re
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from prefplan.errors import ModelError
from prefplan.limits import check_limits
from prefplan.models.graph_files.parallel_edges import dominated_edges, tell_apart

LARGEST_COST = 1e15
"""Costs of a file are floats, which represent all whole numbers up to this exactly."""

LABEL = re.compile(r"[^\s,\[\]'\"]+")
"""A proposition in a list such as `shop bank`, `shop, bank` or `['shop', 'bank']`."""


SAME_EDGES = "files of several costs must list the same edges in the same order"
"""End of the messages for an edge that only one of several files has."""


CLOCK_PERIOD = 10_000
"""Nodes and edges read between two checks of the limits; they take up to 0.1 s."""


class Sink:
    """Receives the nodes and edges of a file. It raises ModelError, to which the reader adds the line.

    By default nodes and edges are counted and ignored.
    """

    _counted = 0

    def count(self) -> None:
        """Count a node or an edge; at the first, and then periodically, check the limits."""
        if self._counted % CLOCK_PERIOD == 0:
            check_limits()
        self._counted += 1

    def wants(self, attribute: str) -> bool:
        """Return whether the reader must pass an attribute."""
        return False

    def node(self, name: str, attributes: Mapping[str, Any]) -> None:
        """Take a node."""
        self.count()

    def edge(self, source: str, target: str, attributes: Mapping[str, Any]) -> None:
        """Take an edge."""
        self.count()

    def mirror(self) -> None:
        """Take every edge so far in the other direction too."""

    def has_degrees(self, per_unit: float) -> None:
        """Note that coordinates are longitudes and latitudes, and how many degrees a unit is."""


@dataclass(frozen=True)
class Network:
    """A graph with one or several costs of each edge.

    Attributes:
        states: (S,) names of the nodes.
        sources: (E,) int64, node that each edge leaves, in the order of the file.
        targets: (E,) int64, node that it leads to.
        costs: (C, E) float64 >= 0, a row for each cost.
        actions: (E,) int64, index into `action_names`; no two edges that leave a node have the same.
        action_names: the target's name unless the file gives one; `name#2` for the second of several between two nodes.
        labels: propositions by node, of the nodes that have any.
        coordinates: (S, 2) float64, or None if a node has none.
        degrees: degrees per unit of the coordinates, if these are longitudes and latitudes; else None.
        dropped: number of edges left out because another between the same nodes dominates them: costs less, or with
            several costs less in one and no more in any.
    """

    states: tuple[str, ...]
    sources: np.ndarray
    targets: np.ndarray
    costs: np.ndarray
    actions: np.ndarray
    action_names: tuple[str, ...]
    labels: Mapping[int, frozenset[str]]
    coordinates: np.ndarray | None
    degrees: float | None
    dropped: int


class NetworkBuilder(Sink):
    """Collects the nodes and edges of a graph."""

    def __init__(self, attributes: Sequence[str | None]) -> None:
        """Take the names of the attributes that are the costs; None for a cost of 1."""
        self._attributes = tuple(attributes)
        self._index: dict[str, int] = {}
        self._declared: set[int] = set()
        self._labels: dict[int, frozenset[str]] = {}
        self._coordinates: dict[int, tuple[float, float]] = {}
        self._action_index: dict[str, int] = {}
        self._sources, self._targets, self._actions = array("q"), array("q"), array("q")
        self._costs = [array("d") for _ in self._attributes]
        self._degrees: float | None = None

    def wants(self, attribute: str) -> bool:
        """Return whether an attribute is used."""
        return attribute in ("action", "labels", "x", "y", *self._attributes)

    def node(self, name: str, attributes: Mapping[str, Any]) -> None:
        """Take a node with its `labels`, `x` and `y`, if it has them."""
        self.count()
        i = self._index.setdefault(name, len(self._index))
        if i in self._declared:
            raise ModelError(f"node {name!r} occurs twice")
        self._declared.add(i)
        if attributes.get("labels"):
            self._labels[i] = _propositions(attributes["labels"], name)
        x, y = attributes.get("x", ""), attributes.get("y", "")
        if x != "" and y != "":
            self._coordinates[i] = _coordinate(x, f"x of node {name!r}"), _coordinate(y, f"y of node {name!r}")

    def edge(self, source: str, target: str, attributes: Mapping[str, Any]) -> None:
        """Take an edge with its costs and `action`; without one, the action has the target's name."""
        self.count()
        index = self._index
        self._sources.append(index.setdefault(source, len(index)))
        self._targets.append(index.setdefault(target, len(index)))
        action = attributes.get("action")
        names = self._action_index
        self._actions.append(names.setdefault(str(action), len(names)) if action not in (None, "") else -1)
        for attribute, column in zip(self._attributes, self._costs, strict=False):
            column.append(1 if attribute is None else _cost(attribute, source, target, attributes))

    def ends(self) -> Iterator[tuple[str, str]]:
        """Yield (source, target) of each edge so far."""
        names = list(self._index)
        for source, target in zip(self._sources, self._targets, strict=True):
            yield names[source], names[target]

    def add_costs(self, costs: array[float]) -> None:
        """Take a further cost of every edge, in the order of the edges."""
        self._costs.append(costs)

    def mirror(self) -> None:
        """Take every edge so far in the other direction too, except self-loops."""
        sources, targets = np.array(self._sources), np.array(self._targets)
        back = sources != targets
        for one, other in ((self._sources, targets), (self._targets, sources)):
            one.frombytes(other[back].tobytes())
        self._actions.frombytes(np.array(self._actions)[back].tobytes())
        for column in self._costs:
            column.frombytes(np.array(column)[back].tobytes())

    def has_degrees(self, per_unit: float) -> None:
        """Note that coordinates are longitudes and latitudes, and how many degrees a unit is."""
        self._degrees = per_unit

    def network(self) -> Network:
        """Return the graph.

        Raises:
            ModelError: an edge has an end that is not listed as a node, or edges of one action lead to different nodes.
        """
        states = tuple(self._index)
        sources, targets, actions = map(np.asarray, (self._sources, self._targets, self._actions))
        costs = np.stack([np.asarray(column) for column in self._costs])
        if self._declared and len(self._declared) < len(states):
            missing = next(i for i in range(len(states)) if i not in self._declared)
            k = int(np.flatnonzero((sources == missing) | (targets == missing))[0])
            ends = f"{states[sources[k]]!r} to {states[targets[k]]!r}"
            raise ModelError(f"edge from {ends}: {states[missing]!r} is not listed as a node")
        kept = ~dominated_edges(sources, targets, costs, len(states))
        sources, targets, actions, costs = sources[kept], targets[kept], actions[kept], costs[:, kept]
        explicit = np.array(
            [self._index.get(name, len(states) + k) for k, name in enumerate(self._action_index)], dtype=np.int64
        )
        names = [*states, *self._action_index]
        actions = np.where(actions < 0, targets, explicit[actions] if len(explicit) else targets)
        tell_apart(sources, targets, actions, names)
        found = self._coordinates
        complete = len(found) == len(states)
        return Network(
            states=states,
            sources=sources,
            targets=targets,
            costs=costs,
            actions=actions,
            action_names=tuple(names),
            labels=self._labels,
            coordinates=np.array([found[i] for i in range(len(states))]) if complete else None,
            degrees=self._degrees,
            dropped=int((~kept).sum()),
        )


class CostReader(Sink):
    """Collects a further cost of the edges of a graph, from a file that lists them in the same order.

    Attributes:
        costs: the cost of each edge so far.
    """

    def __init__(self, builder: NetworkBuilder, attribute: str, *, first: str) -> None:
        """Take the edges, the attribute that is the cost, and the name of the file that the edges are from."""
        self.costs = array("d")
        self._ends, self._attribute, self._first = builder.ends(), attribute, first

    def wants(self, attribute: str) -> bool:
        """Return whether an attribute is the cost."""
        return attribute == self._attribute

    def edge(self, source: str, target: str, attributes: Mapping[str, Any]) -> None:
        """Take the cost of the next edge."""
        self.count()
        ends = next(self._ends, None)
        if ends != (source, target):
            there = "ends" if ends is None else f"has the edge from {ends[0]!r} to {ends[1]!r}"
            raise ModelError(f"edge from {source!r} to {target!r}, where {self._first} {there}; {SAME_EDGES}")
        self.costs.append(_cost(self._attribute, source, target, attributes))

    def check_complete(self) -> None:
        """Raise ModelError if the file, once it is read, lacks an edge."""
        ends = next(self._ends, None)
        if ends is not None:
            raise ModelError(f"no edge from {ends[0]!r} to {ends[1]!r}, which {self._first} has; {SAME_EDGES}")


def _cost(attribute: str, source: str, target: str, attributes: Mapping[str, Any]) -> float:
    value = attributes.get(attribute)
    cost = number_of(value)
    if 0 <= cost <= LARGEST_COST:
        return cost
    edge = f"edge from {source!r} to {target!r}"
    if value is None or value == "":
        raise ModelError(f"{edge}: no {attribute!r}, which is its cost")
    wrong = "not a number" if math.isnan(cost) else "negative" if cost < 0 else f"larger than {LARGEST_COST:g}"
    raise ModelError(f"{edge}: {attribute} is {wrong}: {value!r}")


def number_of(value: Any) -> float:
    """Return a value of a file as a number; NaN if it is not one."""
    if isinstance(value, bool):
        return math.nan
    try:
        return float(value)
    except (TypeError, ValueError):
        return math.nan
    except OverflowError:
        return math.inf


def _coordinate(value: Any, where: str) -> float:
    found = number_of(value)
    if not math.isfinite(found):
        raise ModelError(f"{where}: must be a number, not {value!r}")
    return found


def _propositions(value: Any, name: str) -> frozenset[str]:
    if isinstance(value, str):
        return frozenset(LABEL.findall(value))
    if isinstance(value, list) and all(isinstance(entry, str) for entry in value):
        return frozenset(value)
    raise ModelError(f"labels of node {name!r}: must be a list of names, not {value!r}")
