"""CSV tables of edges and of nodes, with a header line."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from io import TextIOWrapper
from typing import BinaryIO

from prefplan.errors import ModelError, check_known
from prefplan.models.graph_files.network import Sink

NODE_COLUMNS = ("node", "x", "y", "labels")


def read_edges(file: BinaryIO, sink: Sink) -> None:
    """Pass the edges of a table to a sink; it has the columns `from` and `to`, and all others are attributes.

    Raises:
        ModelError: the file is no such table, or the sink refuses an edge; the message begins with the line.
    """
    rows = _rows(file, required=("from", "to"))
    header = next(rows)[1]
    source, target = header.index("from"), header.index("to")
    wanted = [(k, name) for k, name in enumerate(header) if k not in (source, target) and sink.wants(name)]
    for line, row in rows:
        try:
            sink.edge(row[source], row[target], {name: row[k] for k, name in wanted})
        except ModelError as error:
            raise ModelError(f"line {line}: {error}") from None


def read_nodes(file: BinaryIO, sink: Sink) -> None:
    """Pass the nodes of a table to a sink; it has the column `node` and may have `x`, `y` and `labels`.

    Raises:
        ModelError: as in `read_edges`.
    """
    rows = _rows(file, required=("node",))
    header = next(rows)[1]
    for name in header:
        check_known("line 1", "column", name, NODE_COLUMNS)
    for line, row in rows:
        columns = dict(zip(header, row, strict=True))
        try:
            sink.node(columns.pop("node"), columns)
        except ModelError as error:
            raise ModelError(f"line {line}: {error}") from None


def _rows(file: BinaryIO, *, required: tuple[str, ...]) -> Iterator[tuple[int, list[str]]]:
    """Yield (line, fields) of every row that is not empty, the header first."""
    rows = csv.reader(TextIOWrapper(file, encoding="utf-8-sig", newline=""), skipinitialspace=True, strict=True)
    try:
        filled = ((rows.line_num, row) for row in rows if row)
        line, header = next(filled, (1, []))
        for name in required:
            if name not in header:
                raise ModelError(f"line 1: no column {name!r} (columns: {', '.join(header) or 'none'})")
        twice = [name for name in header if header.count(name) > 1]
        if twice:
            raise ModelError(f"line 1: two columns {twice[0]!r}")
        yield line, header
        for line, row in filled:
            if len(row) != len(header):
                raise ModelError(f"line {line}: {len(row)} columns, where the first line names {len(header)}")
            yield line, row
    except csv.Error as error:
        raise ModelError(f"line {rows.line_num}: not CSV: {error}") from None
