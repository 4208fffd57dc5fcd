"""Reading of graph files: the choice of the format and of the attributes that are costs."""

from __future__ import annotations

import gzip
import math
import zlib
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO, cast

from prefplan.errors import ModelError, choices, prefixed
from prefplan.models.graph_files import csv_tables, dimacs, graphml, node_link
from prefplan.models.graph_files.network import CostReader, Network, NetworkBuilder, Sink, number_of

Reader = Callable[[BinaryIO, Sink], None]

EDGE_READERS: dict[str, Reader] = {
    ".graphml": graphml.read,
    ".csv": csv_tables.read_edges,
    ".json": node_link.read,
    ".gr": dimacs.read_arcs,
}
"""Readers of edges by the suffix of a file."""

NODE_READERS: dict[str, Reader] = {".csv": csv_tables.read_nodes, ".co": dimacs.read_coordinates}
"""Readers of nodes by the suffix of a file."""

COMPRESSED = ".gz"

DEFAULT_COST = "cost"
"""Attribute that is the cost if none is named."""

MOST_PROBED = 1000
"""Number of edges that are read to find the attributes that are numbers."""


def read_network(
    folder: Path, file: str | Mapping[str, str], nodes: str | None, cost: str | Mapping[str, str] | None
) -> Network:
    """Read a graph.

    Arguments are the attributes of `GraphFileModel`.

    Raises:
        ModelError: a file cannot be read or is invalid; the message begins with the key and names file and line.
    """
    if isinstance(file, Mapping):
        attributes: list[str | None] = [DEFAULT_COST]
        name, *others = _chosen_files(file, cost)
    else:
        attributes = _chosen_attributes(folder, file, cost)
        name, others = file, []
    builder = NetworkBuilder(attributes)
    if nodes is not None:
        _read(folder, nodes, NODE_READERS, "nodes", builder)
    _read(folder, name, EDGE_READERS, "file", builder)
    for other in others:
        more = CostReader(builder, DEFAULT_COST, first=name)
        _read(folder, other, EDGE_READERS, "file", more)
        with prefixed(f"file: {other}: ", ModelError):
            more.check_complete()
        builder.add_costs(more.costs)
    with prefixed(f"file: {name}: ", ModelError):
        return builder.network()


def attributes_by_key(cost: Any) -> dict[str, Any]:
    """Return the attributes that `cost` names, each by its key."""
    return {f"cost.{key}": one for key, one in cost.items()} if isinstance(cost, Mapping) else {"cost": cost}


def may_have_labels(file: str | Mapping[str, str], nodes: str | None) -> bool:
    """Return whether files, given as to `read_network`, are of formats that have labels."""
    return (isinstance(file, str) and _ending(file) in (".graphml", ".json")) or _ending(nodes or "") == ".csv"


def _chosen_files(files: Mapping[str, str], cost: str | Mapping[str, str] | None) -> list[str]:
    """Return which of several `.gr` files to read: the one that `cost` names, else all."""
    for key, name in files.items():
        if _ending(name) != ".gr":
            raise ModelError(f"file.{key}: must be a file that ends in .gr, not {name!r}; other files have all costs")
    if cost is None:
        return list(files.values())
    if isinstance(cost, Mapping):
        raise ModelError(f"cost: must be one of {', '.join(files)}, or missing for all; each file has one cost")
    if cost not in files:
        raise _unknown_cost(cost, list(files))
    return [files[cost]]


def _chosen_attributes(folder: Path, name: str, wanted: str | Mapping[str, str] | None) -> list[str | None]:
    """Return the attributes that are costs: those wanted, else `cost`, else the only number, else None.

    Raises:
        ModelError: there is no such attribute, or there are several to choose from.
    """
    probe = _Probe()
    with suppress(_EnoughError):
        _read(folder, name, EDGE_READERS, "file", probe)
    numeric = [attribute for attribute, numbers in probe.numbers.items() if numbers == probe.edges]
    sometimes_numeric = [attribute for attribute, numbers in probe.numbers.items() if numbers]
    if wanted is not None:
        by_key = attributes_by_key(wanted)
        for key, one in by_key.items():
            if one not in probe.numbers:
                raise _unknown_cost(one, numeric, key)
        return list(by_key.values())
    if DEFAULT_COST in probe.numbers:
        return [DEFAULT_COST]
    if len(numeric) != 1 and sometimes_numeric:
        valid = ", ".join(numeric or sometimes_numeric)
        raise ModelError(f"cost: missing; it says which number of an edge is its cost (valid: {valid})")
    return [numeric[0] if numeric else None]


def _unknown_cost(wanted: str, numeric: list[str], key: str = "cost") -> ModelError:
    return ModelError(f"{key}: no number {wanted!r} on the edges {choices(wanted, numeric)}")


class _EnoughError(Exception):
    """Enough edges have been probed."""


class _Probe(Sink):
    """Counts the numeric attributes of the first edges of a file.

    Attributes:
        edges: number of edges read.
        numbers: number of edges of which an attribute was a finite number, by attribute.
    """

    def __init__(self) -> None:
        self.edges = 0
        self.numbers: dict[str, int] = {}

    def wants(self, attribute: str) -> bool:
        return True

    def edge(self, source: str, target: str, attributes: Mapping[str, Any]) -> None:
        self.edges += 1
        for name, value in attributes.items():
            if name not in ("source", "target", "key", "action"):
                self.numbers[name] = self.numbers.get(name, 0) + math.isfinite(number_of(value))
        if self.edges == MOST_PROBED:
            raise _EnoughError


def _ending(name: str) -> str:
    """Return the suffix of a file's name, without `.gz`."""
    path = Path(name)
    return (path.with_suffix("") if path.suffix.lower() == COMPRESSED else path).suffix.lower()


def _read(folder: Path, name: str, readers: Mapping[str, Reader], key: str, sink: Sink) -> None:
    reader = readers.get(_ending(name))
    if reader is None:
        raise ModelError(f"{key}: {name}: must end in {', '.join(readers)}, or in one of these and {COMPRESSED}")
    try:
        with prefixed(f"{key}: {name}: ", ModelError), _opened(folder / name) as file:
            reader(file, sink)
    except FileNotFoundError:
        raise ModelError(f"{key}: {name}: no such file beside the scenario") from None
    except (EOFError, zlib.error, gzip.BadGzipFile):
        raise ModelError(f"{key}: {name}: not a complete gzip file") from None
    except UnicodeDecodeError as error:
        raise ModelError(f"{key}: {name}: not UTF-8: {error}") from None
    except OSError as error:
        raise ModelError(f"{key}: {name}: cannot be read ({error.strerror})") from None


def _opened(path: Path) -> BinaryIO:
    return cast(BinaryIO, gzip.open(path)) if path.suffix.lower() == COMPRESSED else path.open("rb")
