"""Graphs written to files in every format that scenarios read."""

from __future__ import annotations

import csv
import gzip
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import networkx as nx

Model = Mapping[str, Any]


def graphml(model: Model, folder: Path) -> dict[str, Any]:
    """Write a graph as OSMnx does, all attributes as texts; return the keys of `[model]`."""
    graph = networkx_graph(model)
    for _, data in graph.nodes(data=True):
        data["labels"] = str(data["labels"])
    for _, _, data in graph.edges(data=True):
        data["cost"] = str(data["cost"])
    nx.write_graphml(graph, folder / "town.graphml", named_key_ids=True)
    return {"file": "town.graphml"}


def node_link(model: Model, folder: Path) -> dict[str, Any]:
    """Write a graph as node-link JSON."""
    graph = networkx_graph(model)
    data = nx.node_link_data(graph, edges="edges" if len(graph) % 2 else "links")
    (folder / "town.json").write_text(json.dumps(data))
    return {"file": "town.json"}


def tables(model: Model, folder: Path) -> dict[str, Any]:
    """Write a graph as a compressed table of edges and one of nodes."""
    with gzip.open(folder / "town.csv.gz", "wt", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["to", "toll", "from", "length", "action"])
        for edge in model["transitions"]:
            rows.writerow([edge["to"], 7, edge["from"], edge["cost"], edge.get("action", "")])
    with (folder / "places.csv").open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["node", "labels"])
        rows.writerows([state, " ".join(model["labels"].get(state, ()))] for state in states_of(model))
    return {"file": "town.csv.gz", "nodes": "places.csv", "cost": "length"}


def dimacs(model: Model, folder: Path) -> dict[str, Any]:
    """Write a graph in the DIMACS format, where nodes are numbers and actions have no names."""
    number = {state: i for i, state in enumerate(states_of(model), start=1)}
    edges = model["transitions"]
    lines = [f"a {number[edge['from']]} {number[edge['to']]} {edge['cost']}" for edge in edges]
    heading = ["c a town", f"p sp {len(number)} {len(edges)}"]
    (folder / "time.gr").write_text("\n".join(heading + lines))
    (folder / "toll.gr").write_text("nothing that is read")
    places = [f"v {i} {1000 * i} {-i}" for i in number.values()]
    (folder / "town.co").write_text("\n".join([f"p aux sp co {len(number)}", *places]))
    return {
        "file": {"time": "time.gr", "toll": "toll.gr"},
        "cost": "time",
        "nodes": "town.co",
        "start": str(number[model["start"]]),
        "labels": {str(number[state]): names for state, names in model["labels"].items()},
    }


WRITERS: Sequence[Callable[[Model, Path], dict[str, Any]]] = (graphml, node_link, tables, dimacs)


def states_of(model: Model) -> list[str]:
    """Return the states that transitions name, the start first."""
    ends = [edge[end] for edge in model["transitions"] for end in ("from", "to")]
    return list(dict.fromkeys([model["start"], *ends]))


def networkx_graph(model: Model) -> nx.MultiDiGraph:
    """Return a model of a scenario file as a graph of networkx."""
    graph = nx.MultiDiGraph(crs="epsg:4326")
    for i, state in enumerate(states_of(model)):
        graph.add_node(state, x=0.5 * i, y=40.0 + i, labels=model["labels"].get(state, []))
    for edge in model["transitions"]:
        attributes = {"cost": float(edge["cost"]), "name": "High Street"}
        if "action" in edge:
            attributes["action"] = edge["action"]
        graph.add_edge(edge["from"], edge["to"], **attributes)
    return graph
