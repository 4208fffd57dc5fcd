"""Node-link JSON, as written by networkx."""

from __future__ import annotations

import json
from typing import Any, BinaryIO

from prefplan.errors import ModelError
from prefplan.models.graph_files.network import Sink

EDGES = ("edges", "links")
"""Keys of the list of edges: that of networkx since 3.4, and that before."""


def read(file: BinaryIO, sink: Sink) -> None:
    """Pass the nodes and edges of a file to a sink; if it is undirected, each edge in both directions.

    Raises:
        ModelError: the file is not node-link JSON, or the sink refuses a node or edge, which the message then names.
    """
    objects = _Objects(sink)
    try:
        top = json.loads(file.read().decode(), object_hook=objects.take)
    except UnicodeDecodeError as error:
        raise ModelError(f"not JSON: {error}") from None
    except json.JSONDecodeError as error:
        raise ModelError(f"line {error.lineno}: not JSON: {error.msg}") from None
    except RecursionError:
        raise ModelError("not JSON: nested too deep") from None
    except ValueError as error:  # an integer of too many digits
        raise ModelError(f"a number is too long: {error}") from None
    if not isinstance(top, dict) or not any(isinstance(top.get(key), list) for key in EDGES):
        raise ModelError(f"not node-link JSON: there is no list {' or '.join(map(repr, EDGES))}")
    edges = next(top[key] for key in EDGES if isinstance(top.get(key), list))
    for key, entries, read in (("nodes", top.get("nodes", []), objects.nodes), ("edges", edges, objects.edges)):
        wrong = next((i for i, entry in enumerate(entries) if entry is not None), None)
        if wrong is not None:
            needed = "'id'" if key == "nodes" else "'source' and 'target'"
            raise ModelError(f"{key}[{wrong}]: must be an object with {needed}")
        if len(entries) != read:
            raise ModelError(f"objects like those in {key!r} occur in other places of the file")
    if top.get("directed", True) is not True:
        sink.mirror()
    if isinstance(top.get("graph"), dict) and "4326" in str(top["graph"].get("crs")):
        sink.has_degrees(1)


class _Objects:
    """Passes the objects of a file on as soon as each is parsed, so that at most one edge is in memory."""

    def __init__(self, sink: Sink) -> None:
        self.nodes, self.edges = 0, 0
        self._sink = sink

    def take(self, found: dict[str, Any]) -> Any:
        """Pass an object on if it is a node or an edge, and return None; return any other object unchanged."""
        try:
            if "source" in found and "target" in found:
                self.edges += 1
                self._sink.edge(_name(found["source"]), _name(found["target"]), found)
                return None
            if "id" in found and "nodes" not in found:
                self.nodes += 1
                self._sink.node(_name(found["id"]), found)
                return None
        except ModelError as error:
            place = f"edges[{self.edges - 1}]" if "source" in found else f"nodes[{self.nodes - 1}]"
            raise ModelError(f"{place}: {error}") from None
        return found


def _name(value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, (str, int)):
        raise ModelError(f"a node's name must be a string or an integer, not {value!r}")
    name = str(value)
    if not name.isascii() and not name.isprintable() and any("\ud800" <= letter <= "\udfff" for letter in name):
        raise ModelError(f"{name!r} is no text: it has half of a character")
    return name
