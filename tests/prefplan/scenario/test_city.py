"""The roads of a made-up city: its cheapest plan costs what another search over its crossings finds."""

from __future__ import annotations

import heapq

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from prefplan import Scenario, TransitionSystem, cheapest_plan
from prefplan.models.graph_file import GraphFileModel
from prefplan.scenario.decode import load


@pytest.fixture(scope="module")
def city() -> Scenario:
    """The scenario that ships; reading its network takes a second."""
    return load("city")


def test_the_citys_cheapest_plan_costs_what_a_search_from_place_to_place_finds(city: Scenario) -> None:
    assert isinstance(city.model, GraphFileModel)
    system = city.model.network.system
    number = {name: i for i, name in enumerate(system.states)}
    kinds = {number[name]: kinds[0] for name, kinds in city.model.labels.items()}
    start = number[str(city.model.start)]
    is_library = np.array([kinds.get(i) == "library" for i in range(len(number))])
    # No library may be passed before the charger, so no road that leaves one is used.
    seconds = {charged: distances(system, [start, *kinds], barred=is_library & (not charged)) for charged in (0, 1)}
    wanted = [("pharmacy", "clinic"), ("depot", "post"), ("bakery", "school"), ("market",), ("charger",)]
    wanted += [("workshop",), ("library", "bank")]
    best = {(start, (0,) * 7): 0.0}
    frontier = [(0.0, start, (0,) * 7)]
    while frontier:
        spent, place, done = heapq.heappop(frontier)
        if all(count == len(places) for count, places in zip(done, wanted, strict=True)):
            break
        if spent > best[place, done]:
            continue
        for other, kind in kinds.items():
            reached = tuple(
                count + (count < len(places) and places[count] == kind)
                for count, places in zip(done, wanted, strict=True)
            )
            after = spent + seconds[done[4]][place][other]
            if reached != done and (done[4] or kind != "library") and after < best.get((other, reached), np.inf):
                best[other, reached] = after
                heapq.heappush(frontier, (after, other, reached))
    assert spent == cheapest_plan(city.problem()).cost


def sources_of(system: TransitionSystem) -> np.ndarray:
    """Return the (E,) states that the edges of a system leave."""
    return np.repeat(np.arange(system.size), np.diff(system.offsets))


def distances(system: TransitionSystem, places: list[int], *, barred: np.ndarray) -> dict[int, np.ndarray]:
    """Return driving times from each place to every crossing, without the roads that leave a barred crossing."""
    sources, seconds = sources_of(system), system.costs[0].entries * float(system.costs[0].unit)
    kept = ~barred[sources]
    ends = sources[kept], system.targets[kept]
    times = dijkstra(csr_array((seconds[kept], ends), shape=(system.size, system.size)), indices=places)
    return dict(zip(places, times, strict=True))
