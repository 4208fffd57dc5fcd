"""Readers of graph files: GraphML, node-link JSON, CSV and the DIMACS format, also compressed with gzip."""

from __future__ import annotations

import csv
import gzip
import json
import warnings
import zlib
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import TextIOWrapper
from itertools import count
from pathlib import Path
from sys import intern
from typing import Any, BinaryIO, TypeVar, cast
from xml.etree.ElementTree import ParseError

import networkx as nx

from prefplan.errors import ModelError, check_known, prefixed
from prefplan.limits import check_limits

T = TypeVar("T")

NODE_COLUMNS = ("node", "x", "y", "labels")

EDGE_LISTS = ("edges", "links")
"""Keys of the list of edges in node-link JSON: that of networkx since 3.4, and that before."""

CHALLENGE_DEGREES = 1e-6
"""Unit of the coordinates of the 9th DIMACS challenge, degrees."""

MOST_DIGITS = 18
"""Longer numbers of nodes and arcs are refused, as Python refuses to parse those of thousands of digits."""

CLOCK_PERIOD = 10_000
"""Nodes, edges or lines read between two checks of the limits; they take up to 0.1 s."""


@dataclass(frozen=True)
class Table:
    """The nodes or the edges of a file, by columns.

    Attributes:
        columns: (R,) values of each attribute, None where a row has none. Nodes have their name as `id`, edges their
            ends as `source` and `target`; an undirected edge has a row for each direction.
        place: where a row is, for messages, such as `line {}: `.
        rows: (R,) what is put there.
    """

    columns: Mapping[str, list[Any]]
    place: str = ""
    rows: Sequence[int] = ()

    def at(self, row: int) -> str:
        """Return the place of a row, which begins a message; empty where the format has none."""
        return self.place.format(self.rows[row]) if self.place else ""


@dataclass(frozen=True)
class Listing:
    """What a file lists: nodes, edges or both.

    Attributes:
        nodes: columns `id` and, where there are any, `x`, `y` and `labels`; others are passed over.
        edges: columns `source`, `target` and the attributes of edges.
        degrees: degrees per unit of the coordinates, if these are longitudes and latitudes; else None.
    """

    nodes: Table = Table({"id": []})
    edges: Table = Table({"source": [], "target": []})
    degrees: float | None = None


def ending(name: str) -> str:
    """Return the suffix of a file's name, without `.gz`."""
    path = Path(name)
    return (path.with_suffix("") if path.suffix.lower() == ".gz" else path).suffix.lower()


def read(folder: Path, name: str, key: str) -> Listing:
    """Read a file of edges (key `file`) or of nodes (key `nodes`).

    Raises:
        ModelError: it cannot be read or is invalid; the message begins with the key, the file and, where the format
            has lines, the line.
    """
    readers = READERS[key]
    if ending(name) not in readers:
        raise ModelError(f"{key}: {name}: must end in {', '.join(readers)}, or in one of these and .gz")
    path = folder / name
    with prefixed(f"{key}: {name}: ", ModelError):
        try:
            opened = gzip.open(path) if path.suffix.lower() == ".gz" else path.open("rb")
            with cast(BinaryIO, opened) as file:
                return readers[ending(name)](file)
        except FileNotFoundError:
            raise ModelError("no such file beside the scenario") from None
        except (EOFError, zlib.error, gzip.BadGzipFile):
            raise ModelError("not a complete gzip file") from None
        except UnicodeDecodeError as error:
            raise ModelError(f"not UTF-8: {error}") from None
        except OSError as error:
            raise ModelError(f"cannot be read ({error.strerror})") from None


def clocked(items: Iterable[T]) -> Iterator[T]:
    """Yield items; at the first, and then periodically, check the limits of time and memory."""
    for number, item in enumerate(items):
        if number % CLOCK_PERIOD == 0:
            check_limits()
        yield item


def _graphml(file: BinaryIO) -> Listing:
    ticks = clocked(count())

    def named(name: str | None) -> str:
        next(ticks)
        if name is None:
            raise ModelError("an <edge> lacks 'source' or 'target', or a <node> 'id'")
        return name

    try:
        with warnings.catch_warnings(action="ignore"):
            graph = nx.read_graphml(file, node_type=named, force_multigraph=True)
    except ParseError as error:
        raise ModelError(f"line {error.position[0]}: not XML: {str(error).partition(':')[0]}") from None
    except (nx.NetworkXError, ValueError, LookupError, TypeError) as error:
        raise ModelError(f"not GraphML: {error}") from None
    nodes = [{**graph.graph["node_default"], **data, "id": name} for name, data in graph.nodes(data=True)]
    directed = graph if graph.is_directed() else graph.to_directed(as_view=True)
    ends = [{"source": source, "target": target} for source, target in directed.edges()]
    edges = [{**graph.graph["edge_default"], **data} for _, _, data in directed.edges(data=True)]
    return Listing(
        Table(_columns(nodes, "id")),
        Table({**_columns(edges), **_columns(ends, "source", "target")}),
        1.0 if "4326" in str(graph.graph.get("crs")) else None,
    )


def _node_link(file: BinaryIO) -> Listing:
    ticks = clocked(count())

    def tick(value: dict[str, Any]) -> dict[str, Any]:
        next(ticks)
        return value

    text = file.read().decode()
    try:
        top = json.loads(text, object_hook=tick)
    except json.JSONDecodeError as error:
        raise ModelError(f"line {error.lineno}: not JSON: {error.msg}") from None
    except RecursionError:
        raise ModelError("not JSON: nested too deep") from None
    except ValueError as error:  # an integer of too many digits
        raise ModelError(f"a number is too long: {error}") from None
    key = next((key for key in EDGE_LISTS if isinstance(top, dict) and isinstance(top.get(key), list)), None)
    if key is None:
        raise ModelError(f"not node-link JSON: there is no list {' or '.join(map(repr, EDGE_LISTS))}")
    nodes, edges = top.get("nodes", []), top[key]
    for kind, entries, names in (("nodes", nodes, ("id",)), ("edges", edges, ("source", "target"))):
        for i, entry in enumerate(entries):
            _check_names(f"{kind}[{i}]: ", entry, names)
    rows = list(range(len(edges)))
    if top.get("directed", True) is not True:
        back = [k for k in rows if edges[k]["source"] != edges[k]["target"]]
        edges = [*edges, *({**edges[k], "source": edges[k]["target"], "target": edges[k]["source"]} for k in back)]
        rows += back
    graph = top.get("graph")
    return Listing(
        Table(_columns(nodes, "id"), "nodes[{}]: ", range(len(nodes))),
        Table(_columns(edges, "source", "target"), "edges[{}]: ", rows),
        1.0 if isinstance(graph, dict) and "4326" in str(graph.get("crs")) else None,
    )


def _columns(entries: Sequence[Mapping[str, Any]], *names: str) -> dict[str, list[Any]]:
    """Return a column for each key of some objects; the values of `names` as text."""
    keys = dict.fromkeys([*names, *(key for entry in entries for key in entry)])
    return {key: [str(e[key]) if key in names else e.get(key) for e in entries] for key in keys}


def _check_names(place: str, entry: Any, names: tuple[str, ...]) -> None:
    """Check an object of node-link JSON that has names of nodes."""
    if not isinstance(entry, dict) or not all(name in entry for name in names):
        raise ModelError(f"{place}must be an object with {' and '.join(map(repr, names))}")
    for value in (entry[name] for name in names):
        if isinstance(value, bool) or not isinstance(value, (str, int)):
            raise ModelError(f"{place}a node's name must be a string or an integer, not {value!r}")
        if any("\ud800" <= letter <= "\udfff" for letter in str(value)):
            raise ModelError(f"{place}{value!r} is no text: it has half of a character")


def _csv_edges(file: BinaryIO) -> Listing:
    return Listing(edges=_csv(file, {"from": "source", "to": "target"}))


def _csv_nodes(file: BinaryIO) -> Listing:
    return Listing(nodes=_csv(file, {"node": "id"}, valid=NODE_COLUMNS))


def _csv(file: BinaryIO, required: Mapping[str, str], *, valid: Sequence[str] = ()) -> Table:
    """Return a table with a header line; `required` has the columns that it must have, and what they are called."""
    rows = csv.reader(TextIOWrapper(file, encoding="utf-8-sig", newline=""), skipinitialspace=True, strict=True)
    try:
        header = next(filter(None, rows), [])
        for name in required:
            if name not in header:
                raise ModelError(f"line 1: no column {name!r} (columns: {', '.join(header) or 'none'})")
        for name in header:
            if valid:
                check_known("line 1", "column", name, valid)
            if header.count(name) > 1:
                raise ModelError(f"line 1: two columns {name!r}")
        return _table(_csv_rows(rows, len(header)), [required.get(name, name) for name in header])
    except csv.Error as error:
        raise ModelError(f"line {rows.line_num}: not CSV: {error}") from None


def _csv_rows(rows: Any, width: int) -> Iterator[tuple[int, list[str]]]:
    """Yield (line, fields) of every row of a reader that is not empty."""
    for row in filter(None, rows):
        if len(row) != width:
            raise ModelError(f"line {rows.line_num}: {len(row)} columns, where the first line names {width}")
        yield rows.line_num, row


def _dimacs_arcs(file: BinaryIO) -> Listing:
    lines = _dimacs_lines(file)
    nodes, arcs = _dimacs_heading(lines, "p sp NODES ARCS")
    edges = _table(_dimacs_records(lines, "a NODE NODE COST"), ["a", "source", "target", "cost"])
    _check_dimacs_nodes(edges, ("source", "target"), nodes)
    if len(edges.rows) != arcs:
        raise ModelError(f"the line 'p sp' says {arcs} arcs, and there are {len(edges.rows)}")
    return Listing(edges=edges)


def _dimacs_nodes(file: BinaryIO) -> Listing:
    lines = _dimacs_lines(file)
    (count,) = _dimacs_heading(lines, "p aux sp co NODES")
    nodes = _table(_dimacs_records(lines, "v NODE X Y"), ["v", "id", "x", "y"])
    _check_dimacs_nodes(nodes, ("id",), count)
    return Listing(nodes=nodes, degrees=CHALLENGE_DEGREES)


def _dimacs_lines(file: BinaryIO) -> Iterator[tuple[int, list[str]]]:
    """Yield (number, words) of every line that is neither empty nor a comment."""
    for number, line in enumerate(file, start=1):
        words = line.decode(errors="replace").split()
        if words and words[0] != "c":
            yield number, words


def _dimacs_heading(lines: Iterator[tuple[int, list[str]]], form: str) -> list[int]:
    """Return the numbers in the first line, which must have a form such as `p sp NODES ARCS`."""
    line, words = next(lines, (1, []))
    fixed = [word for word in form.split() if word.islower()]
    numbers = words[len(fixed) :]
    digits = all(word.isascii() and word.isdigit() and len(word) <= MOST_DIGITS for word in numbers)
    if len(words) != len(form.split()) or words[: len(fixed)] != fixed or not digits:
        raise ModelError(f"line {line}: must be {form!r}, not {' '.join(words)!r}")
    return [int(word) for word in numbers]


def _dimacs_records(lines: Iterable[tuple[int, list[str]]], form: str) -> Iterator[tuple[int, list[str]]]:
    """Yield lines of four words, of which the first is that of a form such as `v NODE X Y`."""
    for line, words in lines:
        if len(words) != 4 or words[0] != form[0]:
            raise ModelError(f"line {line}: must be {form!r}, not {' '.join(words)!r}")
        yield line, words


def _check_dimacs_nodes(table: Table, columns: tuple[str, ...], count: int) -> None:
    nodes = {str(node) for node in range(1, count + 1)}
    for column in columns:
        wrong = next((k for k, name in enumerate(table.columns[column]) if name not in nodes), None)
        if wrong is not None:
            raise ModelError(f"{table.at(wrong)}node {table.columns[column][wrong]} is not one of 1 to {count}")


def _table(lines: Iterable[tuple[int, list[str]]], names: list[str]) -> Table:
    """Return (line, fields) of a file as a table with these columns."""
    columns, numbers = [list[str]() for _ in names], array("q")
    for number, row in clocked(lines):
        numbers.append(number)
        for column, value in zip(columns, row, strict=True):
            column.append(intern(value))
    return Table(dict(zip(names, columns, strict=True)), "line {}: ", numbers)


READERS: dict[str, dict[str, Callable[[BinaryIO], Listing]]] = {
    "file": {".graphml": _graphml, ".csv": _csv_edges, ".json": _node_link, ".gr": _dimacs_arcs},
    "nodes": {".csv": _csv_nodes, ".co": _dimacs_nodes},
}
"""Readers by the key of `[model]` and the suffix of the file that it names."""
