"""The nodes and edges of graph files, as arrays."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from prefplan.errors import ModelError
from prefplan.models.graph_readers import Table

LABEL = re.compile(r"[^\s,\[\]'\"]+")
"""A proposition in a list such as `shop bank`, `shop, bank` or `['shop', 'bank']`."""


@dataclass(frozen=True)
class Network:
    """The nodes and edges of files.

    Attributes:
        states: (S,) names of the nodes.
        sources: (E,) int64, node that each edge leaves, in the order of the file.
        targets: (E,) int64, node that it leads to.
        costs: (C, E) float64 >= 0, a row for each cost.
        actions: (E,) int64, index into `action_names`; no two edges that leave a node have the same.
        action_names: the target's name unless the file gives one; `name#2` for the second of several between two nodes.
        dropped: number of edges left out because another between the same nodes dominates them: no larger in any
            cost, and smaller in one.
        labels: propositions by node, of the nodes that have any.
        coordinates: (S, 2) float64, or None if a node has none.
        degrees: degrees per unit of the coordinates, if these are longitudes and latitudes; else None.
    """

    states: tuple[str, ...]
    sources: np.ndarray
    targets: np.ndarray
    costs: np.ndarray
    actions: np.ndarray
    action_names: tuple[str, ...]
    dropped: int
    labels: Mapping[int, frozenset[str]] = field(default_factory=dict)
    coordinates: np.ndarray | None = None
    degrees: float | None = None


def connected(index: Mapping[str, int], edges: Table, costs: np.ndarray) -> Network:
    """Return the network of the edges that no other edge dominates, without labels and coordinates.

    Args:
        index: number of each node; empty if the files list no nodes.
        edges: columns `source`, `target` and, if there are any, `action`.
        costs: (C, E) float64, the costs of the edges.

    Raises:
        ModelError: an end of an edge is not a node, or edges of one action lead from a node to different nodes.
    """
    if index:
        _check_ends(edges, index)
    numbers = dict(index)
    sources, targets = (
        np.array([numbers.setdefault(node, len(numbers)) for node in edges.columns[end]], dtype=np.int64)
        for end in ("source", "target")
    )
    kept = ~_dominated(sources * len(numbers) + targets, costs)
    sources, targets = sources[kept], targets[kept]
    given = np.array(edges.columns.get("action", [None] * len(kept)), dtype=object)[kept].tolist()
    actions, names = _actions(sources, targets, given, numbers)
    return Network(tuple(numbers), sources, targets, costs[:, kept], actions, names, int((~kept).sum()))


def numbered(nodes: Table) -> dict[str, int]:
    """Return the number of each node."""
    index: dict[str, int] = {}
    for row, name in enumerate(nodes.columns["id"]):
        if index.setdefault(name, row) != row:
            raise ModelError(f"{nodes.at(row)}node {name!r} occurs twice")
    return index


def _check_ends(edges: Table, index: Mapping[str, int]) -> None:
    """Raise ModelError if an edge has an end that is not listed as a node."""
    for ends in zip(edges.columns["source"], edges.columns["target"], strict=True):
        for node in ends:
            if node not in index:
                raise ModelError(f"edge from {ends[0]!r} to {ends[1]!r}: {node!r} is not listed as a node")


def _dominated(pairs: np.ndarray, costs: np.ndarray) -> np.ndarray:
    """Return (E,) bool, the edges that a parallel edge dominates; parallel edges have the same number in `pairs`."""
    dominated = np.zeros(len(pairs), dtype=bool)
    for edges in _groups(pairs):
        for edge in edges:
            other, own = costs[:, edges], costs[:, [edge]]
            dominated[edge] = ((other <= own).all(axis=0) & (other < own).any(axis=0)).any()
    return dominated


def _groups(numbers: np.ndarray) -> list[np.ndarray]:
    """Return, for each number that occurs more than once, where it does, in order."""
    order = np.argsort(numbers, kind="stable")
    starts = np.flatnonzero(np.diff(numbers[order], prepend=-1))
    return [group for group in np.split(order, starts[1:]) if len(group) > 1] if len(starts) < len(numbers) else []


def _actions(
    sources: np.ndarray, targets: np.ndarray, given: Sequence[Any], index: Mapping[str, int]
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return (E,) actions and their names: that given, else the target's; the second of several is `name#2`.

    Raises:
        ModelError: edges of one action lead from a node to different nodes.
    """
    names = dict(index)
    actions = targets.copy()
    for edge, name in enumerate(given):
        if name not in (None, ""):
            actions[edge] = names.setdefault(str(name), len(names))
    known = list(names)
    for edges in _groups(sources * len(names) + actions):
        name = known[actions[edges[0]]]
        if len(set(targets[edges].tolist())) > 1:
            raise ModelError(f"action {name!r} leaves node {known[sources[edges[0]]]!r} twice, to different nodes")
        for number, edge in enumerate(edges[1:], start=2):
            actions[edge] = names.setdefault(f"{name}#{number}", len(names))
    return actions, tuple(names)


def number(value: Any) -> float:
    """Return a value of a file as a number; NaN if it is not one."""
    if isinstance(value, bool):
        return math.nan
    try:
        return float(value)
    except (TypeError, ValueError):
        return math.nan
    except OverflowError:
        return math.inf


def coordinates_of(nodes: Table) -> np.ndarray | None:
    """Return (S, 2) coordinates of nodes, or None if one has none."""
    columns = []
    for name in ("x", "y"):
        values = nodes.columns.get(name, [None])
        if any(value in (None, "") for value in values):
            return None
        columns.append([number(value) for value in values])
        wrong = next((row for row, value in enumerate(columns[-1]) if not math.isfinite(value)), None)
        if wrong is not None:
            node = nodes.columns["id"][wrong]
            raise ModelError(f"{nodes.at(wrong)}{name} of node {node!r}: must be a number, not {values[wrong]!r}")
    return np.array(columns).T if columns[0] else None


def labels_of(nodes: Table) -> dict[int, frozenset[str]]:
    """Return the propositions of the nodes that have any."""
    found = {row: value for row, value in enumerate(nodes.columns.get("labels", ())) if value}
    for row, value in found.items():
        if not isinstance(value, str) and not (isinstance(value, list) and all(isinstance(one, str) for one in value)):
            node = nodes.columns["id"][row]
            raise ModelError(f"{nodes.at(row)}labels of node {node!r}: must be a list of names, not {value!r}")
    return {row: frozenset(LABEL.findall(value) if isinstance(value, str) else value) for row, value in found.items()}
