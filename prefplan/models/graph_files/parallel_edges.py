"""Parallel edges, between the same two nodes: which are kept, and the names of their actions."""

from __future__ import annotations

import numpy as np

from prefplan.errors import ModelError


def dominated_edges(sources: np.ndarray, targets: np.ndarray, costs: np.ndarray, nodes: int) -> np.ndarray:
    """Return (E,) bool, the edges whose costs a parallel edge dominates."""
    pair = sources * nodes + targets
    # In this order an edge is dominated only by earlier ones.
    order = np.lexsort((*costs[::-1], pair))
    beaten = np.zeros(len(order), dtype=bool)
    later = np.arange(len(order))
    for distance in range(1, len(order)):
        later = later[later >= distance]
        later = later[pair[order[later]] == pair[order[later - distance]]]
        if not len(later):
            break
        own, other = costs[:, order[later]], costs[:, order[later - distance]]
        dominated = (other <= own).all(axis=0) & (other < own).any(axis=0)
        beaten[order[later[dominated]]] = True
        later = later[~dominated]
    return beaten


def tell_apart(sources: np.ndarray, targets: np.ndarray, actions: np.ndarray, names: list[str]) -> None:
    """Rename the actions of parallel edges with the same action to `name#2` and so on, in place.

    Raises:
        ModelError: edges of the same action lead to different nodes.
    """
    index = {}
    pair = sources * len(names) + actions
    order = np.argsort(pair, kind="stable")
    again = np.flatnonzero(pair[order[1:]] == pair[order[:-1]]) + 1
    if len(again):
        index = {name: i for i, name in enumerate(names)}
    count, last = 1, -1
    for k in again.tolist():
        edge, before = order[k], order[k - 1]
        count = count + 1 if k == last + 1 else 2
        last = k
        name = names[actions[edge]]
        if targets[edge] != targets[before]:
            raise ModelError(f"action {name!r} leaves node {names[sources[edge]]!r} twice, to different nodes")
        numbered = f"{name}#{count}"
        if numbered not in index:
            index[numbered] = len(names)
            names.append(numbered)
        actions[edge] = index[numbered]
