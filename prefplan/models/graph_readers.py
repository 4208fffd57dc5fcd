"""Readers of graph files: GraphML and node-link JSON by networkx, CSV and DIMACS line by line; also with gzip."""

from __future__ import annotations

import csv
import gc
import gzip
import io
import json
import sys
import warnings
import zlib
from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, cast
from xml.etree.ElementTree import ParseError

from prefplan.errors import ModelError, check_known, prefixed
from prefplan.limits import bounded, check_limits, clocked

if TYPE_CHECKING:
    import networkx as nx

Columns = dict[str, list[Any]]
"""Values of each attribute, one for each node or edge; None or empty where it has none."""

ENDS = ("from", "to")
"""Columns of the nodes that an edge leaves, and leads to."""

COLUMNS = {"file": ("a", *ENDS, "cost"), "nodes": ("v", "node", "x", "y")}
"""Words on a line of a DIMACS file of edges or of nodes; the first one is the kind of the line."""

NODE_COLUMNS = ("node", "x", "y", "labels")

CHALLENGE_DEGREES = 1e-6
"""Unit of the coordinates of the 9th DIMACS challenge, degrees."""

CHUNK_BYTES = 2**20
"""Bytes that are read between two checks of the limits."""


@dataclass(frozen=True)
class Listing:
    """What a file lists: nodes, edges or both.

    Attributes:
        nodes: column `node` with their names and, where there are any, `x`, `y` and `labels`.
        edges: columns `from` and `to` with names of nodes, and the attributes; an undirected edge occurs both ways.
        lines: (E,) the line of each edge; empty if the format has no lines.
        degrees: degrees per unit of the coordinates, if these are longitudes and latitudes; else None.
        place: the key and the file, as the beginning of a message.
    """

    nodes: Columns = field(default_factory=dict)
    edges: Columns = field(default_factory=dict)
    lines: Sequence[int] = ()
    degrees: float | None = None
    place: str = ""

    def edge(self, row: int) -> str:
        """Return where an edge is, as the beginning of a message."""
        line = f"line {self.lines[row]}: " if self.lines else ""
        return f"{self.place}{line}edge from {self.edges['from'][row]!r} to {self.edges['to'][row]!r}"


def ending(name: str) -> str:
    """Return the suffix of a file's name, without `.gz`."""
    return Path(name.lower().removesuffix(".gz")).suffix


def read(folder: Path, name: str, key: str) -> Listing:
    """Read a file of edges (key `file`) or of nodes (key `nodes`).

    Raises:
        ModelError: it cannot be read or is invalid; the message begins with the key, the file and, where the format
            has lines, the line.
    """
    place, collects = f"{key}: {name}: ", gc.isenabled()
    if ending(name) not in READERS[key]:
        raise ModelError(f"{place}must end in {', '.join(READERS[key])}, or in one of these and .gz")
    # Reading makes millions of objects and frees none: garbage collection takes two fifths of the time for GraphML.
    gc.disable()
    with prefixed(place, ModelError):
        try:
            return replace(READERS[key][ending(name)](_contents(folder / name), key), place=place)
        except FileNotFoundError:
            raise ModelError("no such file beside the scenario") from None
        except (OSError, EOFError, zlib.error, ValueError) as error:
            raise ModelError(f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
        finally:
            if collects:
                gc.enable()


def _contents(path: Path) -> bytes:
    """Return the unpacked contents of a regular file, within the limits: 3 MB of zeros may be 3 GB when unpacked."""
    chunks: list[bytes] = []
    path = bounded(path, most=sys.maxsize)
    opened = gzip.open(path) if path.suffix.lower() == ".gz" else path.open("rb")
    with cast(IO[bytes], opened) as file:
        while not chunks or chunks[-1]:
            check_limits()
            chunks.append(file.read(CHUNK_BYTES))
    return b"".join(chunks)


def _graphml(contents: bytes, key: str) -> Listing:
    import networkx as nx  # takes 0.1 s, and few need it

    try:
        with warnings.catch_warnings(action="ignore"):
            return _of_graph(nx.read_graphml(io.BytesIO(contents), node_type=clocked, force_multigraph=True))
    except ParseError as error:
        raise ModelError(f"line {error.position[0]}: not XML: {str(error).partition(':')[0]}") from None
    except (nx.NetworkXError, ValueError, LookupError, TypeError) as error:
        raise ModelError(f"not GraphML: {error}") from None


def _node_link(contents: bytes, key: str) -> Listing:
    import networkx as nx

    try:
        top = {"nodes": [], **json.loads(contents, object_hook=clocked), "multigraph": True}
        edges = "links" if "links" in top and "edges" not in top else "edges"  # before networkx 3.4, and since
        lists = {key: map(clocked, top[key]) for key in ("nodes", edges)}
        graph = nx.node_link_graph(top | lists, directed=True, edges=edges)
        unlisted = list(graph)[len(top["nodes"]) :]
        if unlisted and top["nodes"]:
            raise ModelError(f"{unlisted[0]!r} is the end of an edge, but not listed as a node")
        return _of_graph(graph)
    except json.JSONDecodeError as error:
        raise ModelError(f"line {error.lineno}: not JSON: {error.msg}") from None
    except (nx.NetworkXError, AttributeError, LookupError, RecursionError, TypeError, ValueError) as error:
        parts = "'nodes' with an 'id', 'edges' or 'links' with 'source' and 'target'"
        raise ModelError(f"not node-link JSON ({parts}): {error!r}") from None


def _of_graph(graph: nx.MultiGraph) -> Listing:
    """Return the nodes and edges of a graph, with the default values of attributes that GraphML allows."""
    directed = graph if graph.is_directed() else graph.to_directed(as_view=True)
    listed = list(map(clocked, directed.edges(data=True)))
    nodes = _columns(list(graph.nodes.values()), graph.graph.get("node_default", {}))
    edges = _columns([data for _, _, data in listed], graph.graph.get("edge_default", {}))
    nodes["node"] = list(map(str, graph))
    edges |= {end: [str(edge[k]) for edge in listed] for k, end in enumerate(ENDS)}
    return Listing(nodes, edges, degrees=1.0 if "4326" in str(graph.graph.get("crs")) else None)


def _columns(entries: Sequence[Mapping[str, Any]], default: Mapping[str, Any]) -> Columns:
    names = dict.fromkeys(chain(default, *entries))
    return {name: [entry.get(name, default.get(name)) for entry in entries] for name in names}


def _csv(contents: bytes, key: str) -> Listing:
    """Return the edges or the nodes of a table with a header line."""
    text = io.StringIO(contents.decode("utf-8-sig"), newline="")
    rows = csv.reader(map(clocked, text), skipinitialspace=True, strict=True)
    try:
        header = next(filter(None, rows), [])
        for name in (*(ENDS if key == "file" else NODE_COLUMNS[:1]), *header):
            if header.count(name) != 1:
                wrong = "two columns" if name in header else "no column"
                raise ModelError(f"line 1: {wrong} {name!r} (columns: {', '.join(header) or 'none'})")
            if key == "nodes":
                check_known("line 1", "column", name, NODE_COLUMNS)
        return _table(((rows.line_num, row) for row in rows if row), header, key)
    except csv.Error as error:
        raise ModelError(f"line {rows.line_num}: not CSV: {error}") from None


def _dimacs(contents: bytes, key: str) -> Listing:
    """Return the arcs or the nodes of a file of the 9th DIMACS challenge."""
    lines = enumerate(map(clocked, io.StringIO(contents.decode())), start=1)
    rows = ((line, words) for line, text in lines if (words := text.split()) and words[0] != "c")
    _, heading = next(rows, (1, []))
    listing = replace(_table(rows, COLUMNS[key], key), degrees=CHALLENGE_DEGREES)
    count, kind = len(listing.lines), COLUMNS[key][0]
    if key == "file" and (heading[:2] + heading[3:] != ["p", "sp", str(count)] or not heading[2].isdecimal()):
        raise ModelError(f"must begin with 'p sp NODES ARCS', not {' '.join(heading)!r}; it has {count} arcs")
    for line, word in zip(listing.lines, (listing.edges or listing.nodes)[kind], strict=True):
        if word != kind:
            raise ModelError(f"line {line}: must begin with {kind!r}, not {word!r}")
    for end in ENDS if key == "file" else ():
        for line, name in zip(listing.lines, listing.edges[end], strict=True):
            if not (name.isdecimal() and 1 <= int(name) <= int(heading[2])):
                raise ModelError(f"line {line}: node {name!r} is not from 1 to {heading[2]}")
    return listing


def _table(rows: Iterable[tuple[int, list[str]]], names: Sequence[str], key: str) -> Listing:
    """Return the edges or the nodes of the rows of a table, each given with its line."""
    columns, lines = [list[Any]() for _ in names], array("q")
    for line, row in rows:
        if len(row) != len(names):
            raise ModelError(f"line {line}: {len(row)} columns, where there must be {len(names)}: {' '.join(names)}")
        lines.append(line)
        for column, value in zip(columns, row, strict=True):
            column.append(sys.intern(value))
    table = dict(zip(names, columns, strict=True))
    return Listing(edges=table, lines=lines) if key == "file" else Listing(nodes=table, lines=lines)


READERS: dict[str, dict[str, Callable[[bytes, str], Listing]]] = {
    "file": {".graphml": _graphml, ".csv": _csv, ".json": _node_link, ".gr": _dimacs},
    "nodes": {".csv": _csv, ".co": _dimacs},
}
"""Readers by the key of `[model]` and the suffix of the file that it names."""
