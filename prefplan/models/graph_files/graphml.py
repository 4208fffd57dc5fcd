"""GraphML, as written by OSMnx and networkx."""

from __future__ import annotations

from collections.abc import Mapping
from typing import BinaryIO
from xml.parsers import expat

from prefplan.errors import ModelError
from prefplan.models.graph_files.network import Sink

UNSUPPORTED = ("hyperedge", "port", "endpoint")
"""Elements of GraphML that go beyond plain nodes and edges."""


def read(file: BinaryIO, sink: Sink) -> None:
    """Pass the nodes and edges of a file to a sink; an undirected edge is passed in both directions.

    Raises:
        ModelError: the file is not GraphML, or the sink refuses a node or edge; the message begins with the line.
    """
    document = _Document(sink)
    try:
        document.parser.ParseFile(file)
    except expat.ExpatError as error:
        raise ModelError(f"line {error.lineno}: not XML: {expat.ErrorString(error.code)}") from None
    except LookupError as error:  # the encoding is unknown
        raise ModelError(f"line {document.parser.CurrentLineNumber}: not XML: {error}") from None
    except ModelError as error:
        raise ModelError(f"line {document.parser.CurrentLineNumber}: {error}") from None
    if document.graphs == 0:
        raise ModelError("not GraphML: there is no element <graph>")


class _Document:
    """State of the parser of a file."""

    def __init__(self, sink: Sink) -> None:
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.graphs = 0
        self._sink = sink
        self._names: dict[str, str] = {}
        self._wanted: dict[str, str | None] = {}
        self._defaults: dict[str, dict[str, str]] = {"node": {}, "edge": {}}
        self._key: Mapping[str, str] = {}
        self._undirected = False
        self._element: Mapping[str, str] = {}
        self._attributes: dict[str, str] = {}
        self._text: list[str] = []
        self._reading: str | None = None

    def _start(self, tag: str, given: dict[str, str]) -> None:
        if tag == "data":
            key = given.get("key", "")
            if key not in self._names:
                raise ModelError(f"<data> of an undeclared key {key!r}")
            name = self._wanted[key]
            if name is not None:
                self._read_text(name)
        elif tag in ("node", "edge"):
            self._element = given
            self._attributes = self._defaults[tag].copy()
        elif tag == "key":
            key = _given(given, "id", tag)
            name = given.get("attr.name", key)
            self._key = given
            self._names[key] = name
            self._wanted[key] = name if name == "crs" or self._sink.wants(name) else None
        elif tag == "default":
            if not self._key:
                raise ModelError("<default> outside a <key>")
            self._read_text("default")
        elif tag == "graph":
            self._begin_graph(given)
        elif tag in UNSUPPORTED:
            raise ModelError(f"element <{tag}> is not supported")

    def _begin_graph(self, given: dict[str, str]) -> None:
        self.graphs += 1
        if self.graphs > 1:
            raise ModelError("a second element <graph>; a file must have one")
        direction = given.get("edgedefault", "directed")
        if direction not in ("directed", "undirected"):
            raise ModelError(f"edgedefault: must be directed or undirected, not {direction!r}")
        self._undirected = direction == "undirected"

    def _read_text(self, name: str) -> None:
        self._reading = name
        self._text = []
        self.parser.CharacterDataHandler = self._text.append

    def _end(self, tag: str) -> None:
        if tag == "data":
            if self._reading is not None:
                self._end_data(self._reading)
        elif tag == "edge":
            self._pass_edge()
            self._element = {}
        elif tag == "node":
            self._sink.node(_given(self._element, "id", tag), self._attributes)
            self._element = {}
        elif tag == "default":
            text = self._text_read()
            name = self._names[self._key["id"]]
            for kind, defaults in self._defaults.items():
                if self._key.get("for", "all") in (kind, "all") and self._sink.wants(name):
                    defaults[name] = text

    def _end_data(self, name: str) -> None:
        text = self._text_read()
        if self._element:
            self._attributes[name] = text
        elif name == "crs" and "4326" in text:
            self._sink.has_degrees(1)

    def _text_read(self) -> str:
        self.parser.CharacterDataHandler = None
        self._reading = None
        return "".join(self._text).strip()

    def _pass_edge(self) -> None:
        source, target = _given(self._element, "source", "edge"), _given(self._element, "target", "edge")
        self._sink.edge(source, target, self._attributes)
        directed = self._element.get("directed")
        if (self._undirected if directed is None else directed == "false") and source != target:
            self._sink.edge(target, source, self._attributes)


def _given(given: Mapping[str, str], attribute: str, tag: str) -> str:
    if attribute not in given:
        raise ModelError(f"<{tag}> without {attribute!r}")
    return given[attribute]
