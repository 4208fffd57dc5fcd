"""Time and memory to load graph files: the roads of the made-up city in each format."""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import re
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from experiments.benchmark.road_network import Roads, arcs_text, coordinates_text, road_network
from prefplan.models.graph_file import GraphFileModel


def main() -> None:
    """Print a row of a table for each format."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    roads = road_network()
    print(f"{len(roads.points)} nodes, {len(roads.sources)} edges\n")
    print("| format | MB | read and build, CPU s | peak memory, MB |\n| --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for ending, write in WRITERS.items():
            keys = write(roads, folder)
            size = (folder / keys["file"]).stat().st_size
            context = multiprocessing.get_context("spawn")
            with ProcessPoolExecutor(1, mp_context=context) as alone:
                taken, peak = alone.submit(load, folder, keys, len(roads.sources)).result()
            print(f"| {ending} | {size / 1e6:.0f} | {taken:.1f} | {peak:.0f} |", flush=True)


def load(folder: Path, keys: dict[str, Any], edges: int) -> tuple[float, float]:
    """Load a graph; return CPU seconds to read the file and build the system, and the process's peak memory, MB."""
    model = GraphFileModel(folder, start=1, **keys)
    began = time.process_time()
    assert len(model.network.system.targets) + model.network.dropped == edges
    taken = time.process_time() - began
    # In KiB. `resource` would count the parent process, too.
    peak = re.search(r"VmHWM:\s*(\d+)", Path("/proc/self/status").read_text())
    return taken, int(peak[1]) / 1024 if peak else math.nan


def write_dimacs(roads: Roads, folder: Path) -> dict[str, Any]:
    """Write `.gr` and `.co`; return the keys of the model."""
    (folder / "roads.gr").write_text(arcs_text(roads))
    (folder / "roads.co").write_text(coordinates_text(roads))
    return {"file": "roads.gr", "nodes": "roads.co"}


def write_csv(roads: Roads, folder: Path) -> dict[str, Any]:
    """Write a CSV file of the roads with lengths of 17 digits; return the keys of the model."""
    rows = (f"{source},{target},{length},Main Street\n" for source, target, length in _with_lengths(roads))
    (folder / "roads.csv").write_text("from,to,length,name\n" + "".join(rows))
    return {"file": "roads.csv", "cost": "length"}


def write_json(roads: Roads, folder: Path) -> dict[str, Any]:
    """Write node-link JSON; return the keys of the model."""
    nodes = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(roads.points.tolist(), start=1)]
    edges = [
        {"length": length, "name": "Main Street", "source": source, "target": target, "key": 0}
        for source, target, length in _with_lengths(roads)
    ]
    (folder / "roads.json").write_text(json.dumps({"directed": True, "nodes": nodes, "edges": edges}))
    return {"file": "roads.json", "cost": "length"}


def write_graphml(roads: Roads, folder: Path) -> dict[str, Any]:
    """Write GraphML with the attributes that OSMnx gives most roads, all as strings; return the keys of the model."""
    names = ("osmid", "highway", "name", "length", "travel_time")
    keys = [f'<key id="d{i}" for="edge" attr.name="{name}" attr.type="string"/>' for i, name in enumerate(names)]
    keys += [f'<key id="{name}" for="node" attr.name="{name}" attr.type="string"/>' for name in "xy"]
    with (folder / "roads.graphml").open("w", encoding="utf-8") as file:
        file.write('<graphml xmlns="http://graphml.graphdrawing.org/xmlns">')
        file.write(f'{"".join(keys)}<graph edgedefault="directed">\n')
        for i, (x, y) in enumerate(roads.points.tolist(), start=1):
            file.write(f'<node id="{i}">\n<data key="y">{y}</data>\n<data key="x">{x}</data>\n</node>\n')
        for source, target, length in _with_lengths(roads):
            values = ("12345678", "residential", "Main Street", length, length / 8)
            data = "".join(f'<data key="d{i}">{value}</data>\n' for i, value in enumerate(values))
            file.write(f'<edge source="{source}" target="{target}" id="0">\n{data}</edge>\n')
        file.write("</graph></graphml>\n")
    return {"file": "roads.graphml", "cost": "length"}


WRITERS: dict[str, Callable[[Roads, Path], dict[str, Any]]] = {
    "`.gr`, `.co`": write_dimacs,
    "`.csv`": write_csv,
    "`.json`": write_json,
    "`.graphml`": write_graphml,
}


def _with_lengths(roads: Roads) -> list[tuple[int, int, float]]:
    lengths = ((roads.points[roads.targets] - roads.points[roads.sources]) ** 2).sum(axis=1) ** 0.5
    return list(zip((roads.sources + 1).tolist(), (roads.targets + 1).tolist(), lengths.tolist(), strict=True))


if __name__ == "__main__":
    main()
