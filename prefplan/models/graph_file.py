"""Graph model whose nodes and edges are in files."""

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np

from prefplan.errors import ModelError, check_known, choices
from prefplan.models.costs import DEFAULT_COST
from prefplan.models.graph_readers import ENDS, Listing, ending, read
from prefplan.models.transition_system import TransitionSystem
from prefplan.text.forms import Form, check_fields
from prefplan.text.names import check_names

LARGEST_COST = 1e15
"""Costs of a file are floats, which represent all whole numbers up to this exactly."""

NOT_COSTS = (*ENDS, "key", "id", "action")
"""Attributes of edges that are never their cost."""

MOST_PROBED = 1000
"""Number of edges that are read to find the attributes that are numbers."""

LABEL = re.compile(r"[^\s,\[\]'\"]+")
"""A proposition in a list such as `shop bank`, `shop, bank` or `['shop', 'bank']`."""


@dataclass(frozen=True)
class Network:
    """What the files of a graph hold.

    Attributes:
        system: its transition system. An action has its name in the file, else that of its target; of several with one
            name from one node to another, the second is `name#2`.
        points: (S, 2) float64, positions of the states on a map; None if one has no coordinates.
    """

    system: TransitionSystem
    points: np.ndarray | None


@dataclass(frozen=True)
class GraphFileModel:
    """A graph in a file: GraphML, CSV, node-link JSON or DIMACS, also compressed with gzip.

    Attributes:
        folder: folder of the files.
        file: file of the edges; or several `.gr` files, by the name of the cost in each.
        start: name of the initial node.
        nodes: file of the nodes' coordinates and labels, if that of the edges has none.
        cost: the attribute of an edge that is its cost, or several attributes, by the names of the costs; may be left
            out if an edge has only one number. With several files, the name of the only cost to read; None to read all.
        labels: propositions by node, in addition to those of the files.
        propositions: further names that formulas may use, although no node has them.

    Raises:
        ModelError: (on construction) for a `cost` that is neither text nor a mapping, or invalid names of costs.
    """

    kind: ClassVar[str] = "graph"

    folder: Path = field(metadata={"key": None})
    file: str | Mapping[str, str]
    start: str | int
    nodes: str | None = None
    cost: Annotated[str | Mapping[str, str] | None, Form("the name of an attribute of the edges")] = None
    labels: Mapping[str, Sequence[str]] = field(default_factory=dict)
    propositions: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        """Check the attributes and the names of costs."""
        check_fields(self, ModelError)
        if not self.cost_names:
            raise ModelError(f"{'file' if self.cost is None else 'cost'}: names no cost")
        check_names(self.cost_names, where="cost")

    @property
    def cost_names(self) -> tuple[str, ...]:
        """The names of the costs."""
        named = self.file if self.cost is None else self.cost
        return tuple(named) if isinstance(named, Mapping) else (DEFAULT_COST,)

    @property
    def valid_propositions(self) -> frozenset[str]:
        """Every name that a formula may use; files are read if they may have labels (errors as in `network`)."""
        with_labels = isinstance(self.file, str) and ending(self.file) in (".graphml", ".json")
        if with_labels or ending(self.nodes or "") == ".csv":
            return self.network.system.propositions
        return self.propositions.union(*self.labels.values())

    def transition_system(self) -> TransitionSystem:
        """Return the graph as a weighted transition system; errors as in `network`."""
        return self.network.system

    @cached_property
    def network(self) -> Network:
        """The graph, read at the first access.

        Raises:
            ModelError: a file cannot be read or is invalid, or the start or a label is not of a node; the message
                begins with the key.
        """
        edges, costs = self._edges()
        nodes = edges if self.nodes is None else read(self.folder, self.nodes, "nodes")
        index = _numbered(nodes, edges)
        given = zip(nodes.nodes.get("node", ()), nodes.nodes.get("labels", ()), strict=False)
        label_of = {index[name]: frozenset(LABEL.findall(str(text))) for name, text in given if text}
        check_known("start", "state", str(self.start), index)
        for name, more in self.labels.items():
            check_known("labels", "state", name, index)
            check_names(more, where=f"labels.{name}")
            label_of[index[name]] = label_of.get(index[name], frozenset()).union(more)
        actions = _actions(edges)
        numbers = {name: i for i, name in enumerate(dict.fromkeys(actions))}
        system = TransitionSystem.from_arrays(
            states=tuple(index),
            start=index[str(self.start)],
            sources=np.array([index[name] for name in edges.edges["from"]], dtype=np.int64),
            targets=np.array([index[name] for name in edges.edges["to"]], dtype=np.int64),
            actions=np.array([numbers[name] for name in actions], dtype=np.int64),
            costs=dict(zip(self.cost_names, costs, strict=True)),
            action_names=tuple(numbers),
            label_of=label_of,
            propositions=self.propositions,
        )
        return Network(system, _points(nodes, len(index)))

    def _edges(self) -> tuple[Listing, list[list[float]]]:
        """Return the edges of the first file, and each cost of every edge."""
        if isinstance(self.file, str):
            edges = read(self.folder, self.file, "file")
            if not isinstance(self.cost, Mapping):
                return edges, [_costs(edges, _attribute(edges, "cost", self.cost))]
            return edges, [_costs(edges, _attribute(edges, f"cost.{name}", each)) for name, each in self.cost.items()]
        for name, file in self.file.items():
            if ending(file) != ".gr":
                what = f"a file that ends in .gr, not {file!r}; other files have all costs"
                raise ModelError(f"file.{name}: must be {what}")
        if self.cost not in (None, *self.file):
            raise ModelError(f"cost: must be one of {', '.join(self.file)}, or missing for all; each file has one cost")
        files = [file for name, file in self.file.items() if self.cost in (None, name)]
        first, *others = (read(self.folder, file, "file") for file in files)
        for other in others:
            if any(first.edges[end] != other.edges[end] for end in ENDS):
                raise ModelError(f"{other.place}must list the same edges in the same order as {files[0]}")
        return first, [_costs(edges, DEFAULT_COST) for edges in (first, *others)]


def _attribute(edges: Listing, key: str, wanted: str | None) -> str | None:
    """Return the attribute that is a cost: the one wanted, else `cost`, else the only number, else None."""
    probed = {name: column[:MOST_PROBED] for name, column in edges.edges.items() if name not in NOT_COSTS}
    finite = {name: [math.isfinite(_number(value)) for value in column] for name, column in probed.items()}
    numbers = [name for name, each in finite.items() if all(each)]
    if wanted is not None and wanted not in finite:
        raise ModelError(f"{key}: no number {wanted!r} on the edges {choices(wanted, numbers)}")
    if wanted is not None or DEFAULT_COST in finite:
        return wanted or DEFAULT_COST
    valid = numbers or [name for name, each in finite.items() if any(each)]
    if len(numbers) != 1 and valid:
        raise ModelError(f"{key}: missing; it says which number of an edge is its cost (valid: {', '.join(valid)})")
    return numbers[0] if numbers else None


def _costs(edges: Listing, attribute: str | None) -> list[float]:
    """Return (E,) the cost of every edge: its value of an attribute, or 1 for None."""
    if attribute is None:
        return [1.0] * len(edges.edges["from"])
    values = edges.edges[attribute]
    costs = list(map(_number, values))
    for row, cost in enumerate(costs):
        if not 0 <= cost <= LARGEST_COST:
            why = "not a number" if math.isnan(cost) else "negative" if cost < 0 else f"larger than {LARGEST_COST:g}"
            raise ModelError(f"{edges.edge(row)}: {attribute} is {why}: {values[row]!r}")
    return costs


def _number(value: Any) -> float:
    """Return a value of a file as a number; NaN if it is not one."""
    try:
        no_number = isinstance(value, bool) or (isinstance(value, str) and "_" in value)
        return math.nan if no_number else float(value)
    except (TypeError, ValueError, OverflowError):
        return math.nan


def _numbered(nodes: Listing, edges: Listing) -> dict[str, int]:
    """Return the number of each node; if the files list nodes, all ends of edges must be among them."""
    listed = nodes.nodes.get("node", [])
    index = {name: i for i, name in enumerate(dict.fromkeys(listed or edges.edges["from"] + edges.edges["to"]))}
    if len(index) < len(listed):
        twice = next(name for i, name in enumerate(listed) if index[name] != i)
        raise ModelError(f"{nodes.place}node {twice!r} occurs twice")
    for end in ENDS:
        for row, name in enumerate(edges.edges[end]):
            if name not in index or not name:
                raise ModelError(f"{edges.edge(row)}: {name!r} is not listed as a node")
    return index


def _points(nodes: Listing, count: int) -> np.ndarray | None:
    """Return (S, 2) points of a map for the nodes, or None if one has no coordinates."""
    x, y = (np.array([_number(value) for value in nodes.nodes.get(name, [None] * count)]) for name in ("x", "y"))
    if not np.isfinite(x + y).all():
        return None
    shrunk = 1.0 if nodes.degrees is None else math.cos(math.radians(y.mean() * nodes.degrees))
    return np.stack([shrunk * x, y], axis=1)


def _actions(edges: Listing) -> list[str]:
    """Return (E,) the action of every edge, see `Network`.

    Raises:
        ModelError: edges of one action lead from a node to different nodes.
    """
    sources, targets = (edges.edges[end] for end in ENDS)
    leads, times, actions = dict[tuple[str, str], str](), Counter[tuple[str, str]](), list[str]()
    for source, target, given in zip(sources, targets, edges.edges.get("action", targets), strict=True):
        name = str(given or target)
        if leads.setdefault((source, name), target) != target:
            raise ModelError(f"{edges.place}action {name!r} leaves node {source!r} twice, to different nodes")
        times[source, name] += 1
        actions.append(name if times[source, name] == 1 else f"{name}#{times[source, name]}")
    return actions
