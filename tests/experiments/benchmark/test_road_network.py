"""The made-up city: its roads are those of the scenario that ships, and every place can be reached."""

from __future__ import annotations

import heapq
from itertools import chain
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from experiments.benchmark import road_network
from prefplan import Scenario, TransitionSystem, cheapest_plan
from prefplan.models.graph_file import GraphFileModel
from prefplan.scenario.decode import load


@pytest.fixture(scope="module")
def city() -> Scenario:
    """The scenario that ships; reading its network takes a second."""
    return load("city")


def test_every_crossing_leads_to_every_other_one_and_a_seed_gives_the_same_roads() -> None:
    roads = road_network.road_network(40, 30, seed=3)
    graph = nx.DiGraph(zip(roads.sources.tolist(), roads.targets.tolist(), strict=True))
    assert sorted(graph) == list(range(len(roads.points))) and nx.is_strongly_connected(graph)
    lengths = np.hypot(*(roads.points[roads.targets] - roads.points[roads.sources]).T)
    assert (lengths > 0).all() and (roads.seconds >= 1).all()
    assert (lengths / roads.seconds <= 1.2 * road_network.MAIN_SPEED_M_S).mean() > 0.99
    again = road_network.road_network(40, 30, seed=3)
    assert all(np.array_equal(one, other) for one, other in zip(roads, again, strict=True))


def test_its_files_hold_the_network(tmp_path: Path) -> None:
    roads = road_network.road_network(30, 30, seed=1)
    (tmp_path / "city.gr").write_text(road_network.arcs_text(roads))
    (tmp_path / "city.co").write_text(road_network.coordinates_text(roads))
    network = GraphFileModel(tmp_path, "city.gr", "1", nodes="city.co").network
    system = network.system
    assert [int(state) for state in system.states] == list(range(1, len(roads.points) + 1))
    made = zip(roads.sources.tolist(), roads.targets.tolist(), roads.seconds.tolist(), strict=True)
    seconds = [system.cost(edge) for edge in range(len(system.targets))]
    assert sorted(zip(sources_of(system).tolist(), system.targets.tolist(), seconds, strict=True)) == sorted(made)
    assert network.points is not None and network.dropped == 0
    north = (network.points[:, 1] * 1e-6 - road_network.SOUTH_WEST_DEG[1]) * road_network.DEGREE_M
    assert north == pytest.approx(roads.points[:, 1], abs=1)


def test_the_scenario_that_ships_is_the_network_and_the_places_that_are_made(city: Scenario) -> None:
    model = city.model
    assert isinstance(model, GraphFileModel)
    roads = road_network.road_network()
    assert model.network.system.size == len(roads.points) > 50_000
    assert len(model.network.system.targets) == len(roads.sources)
    made = {str(at + 1): (kind,) for kind, places in road_network.places(roads).items() for at in places}
    assert {name: tuple(kinds) for name, kinds in model.labels.items()} == made
    assert len(list(chain.from_iterable(made.values()))) == 58


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
