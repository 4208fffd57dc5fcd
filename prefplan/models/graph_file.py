"""Graph model whose nodes and edges are in files."""

from __future__ import annotations

import math
import re
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np

from prefplan.errors import ModelError, check_known, choices
from prefplan.exact_costs import Number
from prefplan.models.costs import DEFAULT_COST
from prefplan.models.graph_readers import ENDS, Listing, ending, read
from prefplan.models.transition_system import TransitionSystem
from prefplan.text.forms import Form, check_fields
from prefplan.text.names import check_names

LARGEST_COST = 1e15
"""Costs of a file are floats, which represent all whole numbers up to this exactly."""

NOT_COSTS = (*ENDS, "key", "id", "action")
"""Attributes of edges that are never taken for their cost unasked."""

MOST_PROBED = 1000
"""Number of edges that are looked at to find the attributes that are numbers."""

LABEL = re.compile(r"[^\s,\[\]'\"]+")
"""A proposition in a list such as `shop bank`, `shop, bank` or `['shop', 'bank']`."""


@dataclass(frozen=True)
class Network:
    """What the files of a graph hold.

    Attributes:
        system: its transition system. An action has the name that the file gives, else its target's; the second of
            several that lead from one node to another is `name#2`.
        dropped: number of edges left out because another between the same nodes dominates them: no larger in any
            cost, and smaller in one.
        points: (S, 2) float64, where a map shows the states; None if one has no coordinates.
    """

    system: TransitionSystem
    dropped: int
    points: np.ndarray | None


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
    cost: Annotated[str | Mapping[str, str] | None, Form("the name of an attribute of the edges")] = None
    labels: Mapping[str, Sequence[str]] = field(default_factory=dict)
    propositions: frozenset[str] = frozenset()
    resolution: Number | None = None

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
        index, label_of = _numbered(nodes, edges), _labels(nodes)
        check_known("start", "state", str(self.start), index)
        for name, more in self.labels.items():
            check_known("labels", "state", name, index)
            label_of[index[name]] = label_of.get(index[name], frozenset()).union(more)
        source, target = (np.array([index[name] for name in edges.edges[end]], dtype=np.int64) for end in ENDS)
        kept = np.flatnonzero(~_dominated(source * len(index) + target, costs))
        actions, action_names = _actions(edges, kept, index)
        system = TransitionSystem.from_arrays(
            states=tuple(index),
            start=index[str(self.start)],
            sources=source[kept],
            targets=target[kept],
            actions=actions,
            costs=dict(zip(self.cost_names, costs[:, kept].tolist(), strict=True)),
            action_names=action_names,
            label_of=label_of,
            propositions=self.propositions,
            resolution=self.resolution,
        )
        return Network(system, len(source) - len(kept), _points(nodes, len(index)))

    def _edges(self) -> tuple[Listing, np.ndarray]:
        """Return the edges of the first file, and their (C, E) costs."""
        if isinstance(self.file, str):
            edges, cost = read(self.folder, self.file, "file"), self.cost
            if not isinstance(cost, Mapping):
                return edges, np.array([_costs(edges, _attribute(edges, "cost", cost))])
            attributes = [_attribute(edges, f"cost.{name}", each) for name, each in cost.items()]
            return edges, np.array([_costs(edges, each) for each in attributes])
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
        return first, np.array([_costs(edges, DEFAULT_COST) for edges in (first, *others)])


def _attribute(edges: Listing, key: str, wanted: str | None) -> str | None:
    """Return the attribute that is a cost: the one wanted, else `cost`, else the only number, else None.

    Raises:
        ModelError: there is no such attribute, or there are several to choose from.
    """
    probed = {name: column[:MOST_PROBED] for name, column in edges.edges.items() if name not in NOT_COSTS}
    finite = {name: [math.isfinite(_number(value)) for value in column] for name, column in probed.items()}
    numbers = [name for name, each in finite.items() if all(each)]
    if wanted is not None and wanted not in finite:
        raise ModelError(f"{key}: no number {wanted!r} on the edges {choices(wanted, numbers)}")
    if wanted is not None or DEFAULT_COST in finite:
        return wanted or DEFAULT_COST
    sometimes = [name for name, each in finite.items() if any(each)]
    if len(numbers) != 1 and sometimes:
        valid = ", ".join(numbers or sometimes)
        raise ModelError(f"{key}: missing; it says which number of an edge is its cost (valid: {valid})")
    return numbers[0] if numbers else None


def _costs(edges: Listing, attribute: str | None) -> np.ndarray:
    """Return (E,) the cost of every edge: its value of an attribute, or 1 for None."""
    if attribute is None:
        return np.ones(len(edges.edges["from"]))
    values = edges.edges[attribute]
    costs = np.array([_number(value) for value in values])
    for row in np.flatnonzero(~((costs >= 0) & (costs <= LARGEST_COST)))[:1]:
        cost = costs[row]
        why = "not a number" if math.isnan(cost) else "negative" if cost < 0 else f"larger than {LARGEST_COST:g}"
        raise ModelError(f"{edges.edge(row)}: {attribute} is {why}: {values[row]!r}")
    return costs


def _number(value: Any) -> float:
    """Return a value of a file as a number; NaN if it is not one."""
    try:
        return math.nan if isinstance(value, bool) else float(value)
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
            if name not in index:
                raise ModelError(f"{edges.edge(row)}: {name!r} is not listed as a node")
    return index


def _labels(nodes: Listing) -> dict[int, frozenset[str]]:
    """Return the propositions of the nodes that have any."""
    given = enumerate(nodes.nodes.get("labels", ()))
    return {node: frozenset(LABEL.findall(str(value))) for node, value in given if value}


def _points(nodes: Listing, count: int) -> np.ndarray | None:
    """Return (S, 2) points of a map for the nodes, or None if one has no coordinates."""
    x, y = (np.array([_number(value) for value in nodes.nodes.get(name, [None] * count)]) for name in ("x", "y"))
    if not np.isfinite(x + y).all():
        return None
    shrunk = 1.0 if nodes.degrees is None else math.cos(math.radians(y.mean() * nodes.degrees))
    return np.stack([shrunk * x, y], axis=1)


def _dominated(pairs: np.ndarray, costs: np.ndarray) -> np.ndarray:
    """Return (E,) bool, the edges that a parallel edge dominates; parallel edges have the same number in `pairs`."""
    dominated = np.zeros(len(pairs), dtype=bool)
    _, pair, counts = np.unique(pairs, return_inverse=True, return_counts=True)
    parallel = defaultdict[int, list[int]](list)
    for edge in np.flatnonzero(counts[pair] > 1).tolist():
        parallel[pair[edge]].append(edge)
    for edges in parallel.values():
        for edge in edges:
            other, own = costs[:, edges], costs[:, [edge]]
            dominated[edge] = ((other <= own).all(axis=0) & (other < own).any(axis=0)).any()
    return dominated


def _actions(edges: Listing, rows: np.ndarray, index: Mapping[str, int]) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return the action of some edges and the names of all actions, see `Network`.

    Raises:
        ModelError: edges of one action lead from a node to different nodes.
    """
    sources, targets = (edges.edges[end] for end in ENDS)
    given = edges.edges.get("action", targets)
    names, actions = dict(index), list[int]()
    leads, times = dict[tuple[str, str], str](), Counter[tuple[str, str]]()
    for row in rows.tolist():
        name = str(given[row] or targets[row])
        action = sources[row], name
        if leads.setdefault(action, targets[row]) != targets[row]:
            where = f"{edges.place}action {name!r} leaves node {sources[row]!r}"
            raise ModelError(f"{where} twice, to different nodes")
        times[action] += 1
        numbered = name if times[action] == 1 else f"{name}#{times[action]}"
        actions.append(names.setdefault(numbered, len(names)))
    return np.array(actions, dtype=np.int64), tuple(names)
