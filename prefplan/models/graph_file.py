"""Graph model whose nodes and edges are in files."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from prefplan.errors import ModelError, check_known, choices, prefixed
from prefplan.exact_costs import Number, exact, exact_floats
from prefplan.models.graph_network import Network, connected, coordinates_of, labels_of, number, numbered
from prefplan.models.graph_readers import Listing, Table, ending, read
from prefplan.models.several_costs import with_costs
from prefplan.models.transition_system import DEFAULT_COST, TransitionSystem
from prefplan.text.names import check_names

LARGEST_COST = 1e15
"""Costs of a file are floats, which represent all whole numbers up to this exactly."""

NOT_COSTS = ("source", "target", "key", "id", "action")
"""Attributes of edges that are never taken for their cost unasked."""

MOST_PROBED = 1000
"""Number of edges that are looked at to find the attributes that are numbers."""


@dataclass(frozen=True)
class GraphFileModel:
    """A graph in a file: GraphML, CSV, node-link JSON or DIMACS, also compressed with gzip.

    Attributes:
        folder: folder of the files.
        file: file of the edges; or several `.gr` files, by the name of the cost in each.
        start: name of the initial node.
        nodes: file of the nodes' coordinates and labels, if that of the edges has none.
        cost: the attribute of an edge that is its cost, or several, by the names of the costs; may be left out if an
            edge has only one number. With several files, the name of the only one to read; None to read all.
        labels: propositions by node, in addition to those of the files.
        propositions: further names that formulas may use, although no node has them.
        resolution: costs are rounded to multiples of this, as in `TransitionSystem.from_transitions`.

    Raises:
        ModelError: (on construction) for a `cost` that is not the name of an attribute, or invalid names of costs.
    """

    kind: ClassVar[str] = "graph"

    folder: Path = field(metadata={"key": None})
    file: str | Mapping[str, str]
    start: str | int
    nodes: str | None = None
    cost: Any = None
    labels: Mapping[str, Sequence[str]] = field(default_factory=dict)
    propositions: frozenset[str] = frozenset()
    resolution: Number | None = None

    def __post_init__(self) -> None:
        """Check the kind of `cost` and the names of costs."""
        for key, named in (("file", self.file), ("cost", self.cost)):
            if isinstance(named, Mapping):
                if not named:
                    raise ModelError(f"{key}: names no cost")
                check_names(named, where=key)
        for key, attribute in self._cost_attributes.items():
            if not isinstance(attribute, str) and self.cost is not None:
                raise ModelError(f"{key}: must be the name of an attribute of the edges, not {attribute!r}")

    @property
    def cost_names(self) -> tuple[str, ...]:
        """The names of the costs."""
        named = self.file if self.cost is None else self.cost
        return tuple(named) if isinstance(named, Mapping) else (DEFAULT_COST,)

    @property
    def known_propositions(self) -> frozenset[str]:
        """Every name that a formula may use; files are read if they may have labels.

        Raises:
            ModelError: as in `network`.
        """
        with_nodes = isinstance(self.file, str) and ending(self.file) in (".graphml", ".json")
        read = self.network.labels.values() if with_nodes or ending(self.nodes or "") == ".csv" else ()
        return self.propositions.union(*self.labels.values(), *read)

    @cached_property
    def network(self) -> Network:
        """The graph, read at the first access.

        Raises:
            ModelError: a file cannot be read or is invalid; the message begins with the key.
        """
        name, listing, costs = self._edges()
        edges, nodes, degrees = listing.edges, listing.nodes, listing.degrees
        place = f"file: {name}: "
        if self.nodes is not None:
            more = read(self.folder, self.nodes, "nodes")
            nodes, degrees = more.nodes, more.degrees
            place = f"nodes: {self.nodes}: "
        with prefixed(place, ModelError):
            index, labels, coordinates = numbered(nodes), labels_of(nodes), coordinates_of(nodes)
        with prefixed(f"file: {name}: ", ModelError):
            found = connected(index, edges, costs)
        complete = len(found.states) == len(index)
        return replace(found, labels=labels, coordinates=coordinates if complete else None, degrees=degrees)

    def transition_system(self) -> TransitionSystem:
        """Return the graph as a weighted transition system.

        Raises:
            ModelError: as in `network`, or the start or a label is not of a node.
        """
        network = self.network
        index = {name: i for i, name in enumerate(network.states)}
        check_known("start", "state", str(self.start), index)
        label_of = dict(network.labels)
        for name, names in self.labels.items():
            check_known("labels", "state", name, index)
            label_of[index[name]] = label_of.get(index[name], frozenset()) | frozenset(names)
        resolution = None if self.resolution is None else exact(self.resolution, "resolution")
        rows = dict(zip(self.cost_names, network.costs, strict=True))

        def build(name: str) -> TransitionSystem:
            multiples, unit, rounded_to = exact_floats(rows[name], resolution)
            return TransitionSystem.from_arrays(
                states=network.states,
                start=index[str(self.start)],
                sources=network.sources,
                targets=network.targets,
                actions=network.actions,
                costs=multiples,
                unit=unit,
                action_names=network.action_names,
                label_of=label_of,
                propositions=self.propositions,
                resolution=rounded_to,
            )

        return with_costs(self.cost_names, build)

    @property
    def _cost_attributes(self) -> dict[str, Any]:
        """The attributes that `cost` names, each by its key."""
        named = self.cost
        return {f"cost.{key}": one for key, one in named.items()} if isinstance(named, Mapping) else {"cost": named}

    def _edges(self) -> tuple[str, Listing, np.ndarray]:
        """Return the file of the edges, what it lists, and (C, E) costs of the edges."""
        if isinstance(self.file, str):
            listing = read(self.folder, self.file, "file")
            attributes = self._chosen_attributes(listing.edges)
            with prefixed(f"file: {self.file}: ", ModelError):
                return self.file, listing, np.array([_costs(listing.edges, attribute) for attribute in attributes])
        (first, *others), costs = self._chosen_files(self.file), []
        for name in (first, *others):
            other = read(self.folder, name, "file")
            listing = other if name == first else listing
            with prefixed(f"file: {name}: ", ModelError):
                _check_same_edges(listing.edges, other.edges, first)
                costs.append(_costs(other.edges, DEFAULT_COST))
        return first, listing, np.array(costs)

    def _chosen_files(self, files: Mapping[str, str]) -> list[str]:
        """Return which of several `.gr` files to read: the one that `cost` names, else all."""
        for key, name in files.items():
            if ending(name) != ".gr":
                raise ModelError(
                    f"file.{key}: must be a file that ends in .gr, not {name!r}; other files have all costs"
                )
        if self.cost is None:
            return list(files.values())
        if isinstance(self.cost, Mapping):
            raise ModelError(f"cost: must be one of {', '.join(files)}, or missing for all; each file has one cost")
        if self.cost not in files:
            raise _unknown_cost("cost", self.cost, files)
        return [files[self.cost]]

    def _chosen_attributes(self, edges: Table) -> list[str | None]:
        """Return the attributes that are costs: those that `cost` names, else `cost`, else the only number, else None.

        Raises:
            ModelError: there is no such attribute, or there are several to choose from.
        """
        probed = {name: column[:MOST_PROBED] for name, column in edges.columns.items() if name not in NOT_COSTS}
        finite = {name: [math.isfinite(number(value)) for value in column] for name, column in probed.items()}
        numeric = [name for name, each in finite.items() if all(each)]
        if self.cost is not None:
            for key, wanted in self._cost_attributes.items():
                if wanted not in finite:
                    raise _unknown_cost(key, wanted, numeric)
            return list(self._cost_attributes.values())
        if DEFAULT_COST in finite:
            return [DEFAULT_COST]
        sometimes = [name for name, each in finite.items() if any(each)]
        if len(numeric) != 1 and sometimes:
            valid = ", ".join(numeric or sometimes)
            raise ModelError(f"cost: missing; it says which number of an edge is its cost (valid: {valid})")
        return [numeric[0] if numeric else None]


def _unknown_cost(key: str, wanted: str, valid: Iterable[str]) -> ModelError:
    return ModelError(f"{key}: no number {wanted!r} on the edges {choices(wanted, valid)}")


def _edge(edges: Table, row: int) -> str:
    return f"edge from {edges.columns['source'][row]!r} to {edges.columns['target'][row]!r}"


def _check_same_edges(edges: Table, other: Table, first: str) -> None:
    """Raise ModelError unless another file lists the edges of the file `first` in the same order."""
    rule = "files of several costs must list the same edges in the same order"
    count, found = (len(table.columns["source"]) for table in (edges, other))
    for row in range(max(count, found)):
        if row >= found:
            raise ModelError(f"no {_edge(edges, row)}, which {first} has; {rule}")
        if row >= count:
            raise ModelError(f"{other.at(row)}{_edge(other, row)}, where {first} ends; {rule}")
        if any(edges.columns[end][row] != other.columns[end][row] for end in ("source", "target")):
            there = f"where {first} has the {_edge(edges, row)}"
            raise ModelError(f"{other.at(row)}{_edge(other, row)}, {there}; {rule}")


def _costs(edges: Table, attribute: str | None) -> list[float]:
    """Return the cost of every edge: its value of an attribute, or 1 for None."""
    if attribute is None:
        return [1.0] * len(edges.columns["source"])
    costs = [number(value) for value in edges.columns[attribute]]
    wrong = next((row for row, cost in enumerate(costs) if not 0 <= cost <= LARGEST_COST), None)
    if wrong is None:
        return costs
    edge, value, cost = edges.at(wrong) + _edge(edges, wrong), edges.columns[attribute][wrong], costs[wrong]
    if value is None or value == "":
        raise ModelError(f"{edge}: no {attribute!r}, which is its cost")
    why = "not a number" if math.isnan(cost) else "negative" if cost < 0 else f"larger than {LARGEST_COST:g}"
    raise ModelError(f"{edge}: {attribute} is {why}: {value!r}")
