"""Graph model whose nodes and edges are in files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from prefplan.errors import ModelError, check_known
from prefplan.exact_costs import Number, exact, exact_floats
from prefplan.models.graph_files.network import Network
from prefplan.models.graph_files.reading import attributes_by_key, may_have_labels, read_network
from prefplan.models.several_costs import with_costs
from prefplan.models.transition_system import DEFAULT_COST, TransitionSystem
from prefplan.names import check_names


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
        for key, attribute in attributes_by_key(self.cost).items():
            if not isinstance(attribute, str) and self.cost is not None:
                raise ModelError(f"{key}: must be the name of an attribute of the edges, not {attribute!r}")

    @cached_property
    def network(self) -> Network:
        """The graph, read at the first access.

        Raises:
            ModelError: a file cannot be read or is invalid; the message begins with the key.
        """
        return read_network(self.folder, self.file, self.nodes, self.cost)

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
        read = self.network.labels.values() if may_have_labels(self.file, self.nodes) else ()
        return self.propositions.union(*self.labels.values(), *read)

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
