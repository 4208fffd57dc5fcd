"""Propositions that no reachable state carries: a likely mistake in a task."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from prefplan import ModelError, Task, TransitionSystem
from prefplan.errors import LimitError
from prefplan.limits import Limits, check_limits, interruptible
from prefplan.logic.formula import propositions_of
from prefplan.models.system import System

LIST_TIMEOUT_S = 3.0
"""Time limit for listing all states, s; planning does not need the list."""


def uncarried(i: int, task: Task, carried: Mapping[str, int | None]) -> Iterator[str]:
    """Yield a sentence for each proposition of the i-th task that no reachable state carries.

    `carried` says for each proposition how many reachable states carry it; None if that is unknown.
    """
    mentions = [("formula", task.tree), *((f"relax[{k}].when", one.condition) for k, one in enumerate(task.relax))]
    for key, formula in mentions:
        for name in sorted(propositions_of(formula)):
            if carried[name] == 0:
                yield f"tasks[{i}].{key}: no state that can be reached carries {name!r}"


def size_of(system: System, limits: Limits) -> dict[str, Any]:
    """Return the entries of `checkup.check` on a system's size, None if its states cannot be listed within limits."""
    try:
        with interruptible(limits), Limits(LIST_TIMEOUT_S):
            check_limits()
            table = system.listed
            reached = reachable(table)
    except (LimitError, ModelError):
        unknown = dict.fromkeys(sorted(system.propositions))
        return {"states": None, "reachable": None, "edges": None, "propositions": unknown}
    counts = np.bincount(table.labels[reached], minlength=len(table.label_sets)).tolist()
    carried = {
        name: sum(count for count, label in zip(counts, table.label_sets, strict=True) if name in label)
        for name in sorted(table.propositions)
    }
    return {"states": table.size, "reachable": len(reached), "edges": len(table.targets), "propositions": carried}


def reachable(system: TransitionSystem) -> np.ndarray:
    """Return the indices of the reachable states, breadth first from the start, within the present limits."""
    met = np.zeros(system.size, dtype=np.bool_)
    layers, layer = list[np.ndarray](), np.array([system.start])
    while len(layer):
        check_limits()
        met[layer] = True
        layers.append(layer)
        first, counts = system.offsets[layer], system.offsets[layer + 1] - system.offsets[layer]
        before = np.cumsum(counts) - counts
        ahead = system.targets[np.repeat(first - before, counts) + np.arange(counts.sum())]
        layer = np.unique(ahead[~met[ahead]])
    return np.concatenate(layers)
