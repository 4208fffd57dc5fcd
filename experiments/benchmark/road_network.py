"""Roads of a made-up city: makes the files of the scenario `city`.

Crossings lie on a jittered grid that is denser downtown and ends at an uneven edge. Some streets are missing, some are
one-way, every few blocks a faster road runs through, and only these roads cross the river.
"""

from __future__ import annotations

import gzip
from typing import NamedTuple

import networkx as nx
import numpy as np

from experiments import scenarios
from experiments.cli.files import write_bytes

COLUMNS, ROWS = 310, 268
"""Crossings from west to east and from south to north, before those outside the city are removed."""

BLOCK_M = 90.0
"""Distance of crossings, on average."""

JITTER = 0.28
"""Greatest distance of a crossing from its grid point along each axis, blocks."""

CENTRE_SHARE = 0.35
"""Share by which distances between crossings are smaller in the centre."""

MAIN_ROADS = 12
"""Blocks between two main roads."""

SPEED_M_S, MAIN_SPEED_M_S = 8.0, 16.0
"""Speed on streets and on main roads."""

MISSING_SHARE, ONE_WAY_SHARE = 0.29, 0.1
"""Shares of streets that are missing, and that are one-way."""

EDGE = 0.1
"""Unevenness of the city's edge, as a share of its radius."""

RIVER_BEND, RIVER_BLOCKS = 0.1, 1.6
"""Amplitude of the river's bends, as a share of half the city's height, and half its width in blocks."""

DEGREE_M = 111_320.0
"""Length of a degree of latitude, m."""

SOUTH_WEST_DEG = (10.0, 50.0)
"""Longitude and latitude of the corner."""

LABELLED = {
    "pharmacy": 6,
    "clinic": 4,
    "post": 6,
    "depot": 3,
    "bakery": 8,
    "school": 5,
    "market": 5,
    "charger": 8,
    "workshop": 3,
    "library": 4,
    "bank": 6,
}
"""Number of places of each kind."""


class Roads(NamedTuple):
    """A road network.

    Attributes:
        points: (S, 2) metres from the south-western corner.
        sources: (E,) crossing that each road leaves, sorted.
        targets: (E,) crossing that it leads to.
        seconds: (E,) int64, driving time.
    """

    points: np.ndarray
    sources: np.ndarray
    targets: np.ndarray
    seconds: np.ndarray


def road_network(columns: int = COLUMNS, rows: int = ROWS, *, seed: int = 0) -> Roads:
    """Return a road network in which every crossing can be reached from every other one."""
    rng = np.random.default_rng(seed)
    x, y = np.tile(np.arange(columns), rows), np.repeat(np.arange(rows), columns)
    points = np.stack([x, y], axis=1) + rng.uniform(-JITTER, JITTER, (columns * rows, 2))
    # Scaled to -1 .. 1 in both directions.
    place = 2 * points / (columns - 1, rows - 1) - 1
    is_bridge = x % MAIN_ROADS == 0
    exists = _inside(place) & (is_bridge | ~_in_river(place, rows))
    number = np.arange(columns * rows).reshape(rows, columns)
    east = np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()])
    north = np.stack([number[:-1].ravel(), number[1:].ravel()])
    is_main = np.concatenate([y[east[0]] % MAIN_ROADS == 0, is_bridge[north[0]]])
    first, second = np.hstack([east, north])
    kept = exists[first] & exists[second] & (is_main | (rng.random(len(first)) >= MISSING_SHARE))
    first, second, is_main = first[kept], second[kept], is_main[kept]
    there = is_main | (rng.random(len(first)) >= ONE_WAY_SHARE / 2)
    back = is_main | ~there | (rng.random(len(first)) >= ONE_WAY_SHARE / 2)
    sources = np.concatenate([first[there], second[back]])
    targets = np.concatenate([second[there], first[back]])
    speed = np.where(np.concatenate([is_main[there], is_main[back]]), MAIN_SPEED_M_S, SPEED_M_S)
    points = _denser_downtown(place) * (columns * BLOCK_M / 2, rows * BLOCK_M / 2)
    seconds = np.rint(np.hypot(*(points[targets] - points[sources]).T) / speed).astype(np.int64)
    return _connected(Roads(points, sources, targets, np.maximum(seconds, 1)))


def _inside(place: np.ndarray) -> np.ndarray:
    """Return which (S, 2) places lie inside the edge of the city."""
    angle = np.arctan2(place[:, 1], place[:, 0])
    edge = 1 - EDGE * (1 + np.sin(3 * angle + 1) + 0.5 * np.sin(7 * angle))
    return np.asarray(np.hypot(*place.T) < edge)


def _in_river(place: np.ndarray, rows: int) -> np.ndarray:
    """Return which (S, 2) places lie in the river, which runs from west to east."""
    middle = RIVER_BEND * np.sin(4 * place[:, 0]) - 0.2
    return np.asarray(np.abs(place[:, 1] - middle) < 2 * RIVER_BLOCKS / rows)


def _denser_downtown(place: np.ndarray) -> np.ndarray:
    """Return (S, 2) places, those downtown moved towards the middle."""
    away = np.hypot(*place.T)
    return np.asarray(place * (1 - CENTRE_SHARE * (1 - away).clip(min=0))[:, None])


def _connected(roads: Roads) -> Roads:
    """Return the largest part of which every crossing can be reached from every other one, sorted."""
    links = nx.DiGraph(zip(roads.sources.tolist(), roads.targets.tolist(), strict=True))
    inside = np.zeros(len(roads.points), dtype=np.bool_)
    inside[max(map(list, nx.strongly_connected_components(links)), key=len)] = True
    number = np.cumsum(inside) - 1
    kept = np.flatnonzero(inside[roads.sources] & inside[roads.targets])
    kept = kept[np.lexsort((roads.targets[kept], roads.sources[kept]))]
    return Roads(roads.points[inside], number[roads.sources[kept]], number[roads.targets[kept]], roads.seconds[kept])


def places(roads: Roads) -> dict[str, list[int]]:
    """Return the crossings of each kind of place, drawn at random without repetition."""
    drawn = iter(np.random.default_rng(0).permutation(len(roads.points)).tolist())
    return {kind: sorted(next(drawn) for _ in range(count)) for kind, count in LABELLED.items()}


def arcs_text(roads: Roads, what: str = "driving times, s") -> str:
    """Return the roads in the DIMACS format; crossings are counted from 1. A comment says what the costs are."""
    edges = zip((roads.sources + 1).tolist(), (roads.targets + 1).tolist(), roads.seconds.tolist(), strict=True)
    heading = f"c {what}\np sp {len(roads.points)} {len(roads.sources)}\n"
    return heading + "".join(f"a {source} {target} {seconds}\n" for source, target, seconds in edges)


def coordinates_text(roads: Roads) -> str:
    """Return the crossings in the DIMACS format, in millionths of a degree, exact to a metre."""
    per_metre = np.array([1 / np.cos(np.radians(SOUTH_WEST_DEG[1])), 1]) / DEGREE_M
    lines = np.rint((roads.points * per_metre + SOUTH_WEST_DEG) * 1e5).astype(np.int64) * 10
    heading = f"c longitude and latitude, degrees * 1e6\np aux sp co {len(lines)}\n"
    return heading + "".join(f"v {i} {x} {y}\n" for i, (x, y) in enumerate(lines.tolist(), start=1))


def main() -> None:
    """Write the files of the scenario, and print its labels."""
    roads = road_network()
    for ending, text in (("gr", arcs_text(roads)), ("co", coordinates_text(roads))):
        write_bytes(scenarios.FOLDER / f"city.{ending}.gz", gzip.compress(text.encode(), mtime=0))
    print(f"# {len(roads.points)} crossings, {len(roads.sources)} roads\n\n[model.labels]")
    for kind, crossings in places(roads).items():
        print("\n".join(f'{crossing + 1} = ["{kind}"]' for crossing in crossings))


if __name__ == "__main__":
    main()
