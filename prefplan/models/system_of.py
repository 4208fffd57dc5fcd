"""The transition system of what a user gives for one."""

from __future__ import annotations

import sys
from collections.abc import Hashable
from typing import TYPE_CHECKING, Protocol, TypeAlias, runtime_checkable

from prefplan.errors import ModelError, describe
from prefplan.models.system import System
from prefplan.models.transition_system import TransitionSystem

if TYPE_CHECKING:
    import networkx as nx


@runtime_checkable
class Model(Protocol):
    """The interface of a model, such as `GridModel`."""

    def transition_system(self) -> System:
        """Return its transition system."""


SystemLike: TypeAlias = "System | Model | nx.Graph"
"""What a user may give for a transition system, see `system_of`."""


def system_of(given: SystemLike, *, start: Hashable | None = None) -> System:
    """Return the transition system that is given itself, as a model, or as a graph for `from_networkx`.

    `start` is a graph's initial node; None for its attribute `start`, which `TransitionSystem.to_networkx` sets.

    Raises:
        ModelError: it is something else, a graph without a start, or anything but a graph with one.
    """
    # It takes 0.1 s to load networkx; who has a graph has loaded it.
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
