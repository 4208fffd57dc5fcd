"""The grid model: cells, moves, regions and obstacles."""

from __future__ import annotations

import random
from typing import Any

import pytest

from prefplan import GridModel, ModelError, TransitionSystem

MOVES = {"N": (0, 1), "S": (0, -1), "E": (1, 0), "W": (-1, 0)}


def moves(system: TransitionSystem, cell: tuple[int, int]) -> dict[str, tuple[int, int]]:
    """Return the cell each action leads to, in the model's order."""
    state = list(system.states).index(cell)
    names = [system.action_names[system.actions[edge]] for edge in system.edges(state)]
    return {name: system.states[system.step(state, name)[0]] for name in names}


def label(system: TransitionSystem, cell: tuple[int, int]) -> frozenset[str]:
    return system.label(list(system.states).index(cell))


def test_moves_are_tried_north_south_east_west() -> None:
    system = GridModel((3, 3), (1, 1)).transition_system()
    assert list(moves(system, (1, 1)).items()) == [("N", (1, 2)), ("S", (1, 0)), ("E", (2, 1)), ("W", (0, 1))]
    assert system.action_names == ("N", "S", "E", "W")
    assert system.states[system.start] == (1, 1)


def test_the_origin_is_the_lower_left_cell_and_moves_off_the_grid_do_not_exist() -> None:
    system = GridModel((3, 2), (0, 0)).transition_system()
    assert moves(system, (0, 0)) == {"N": (0, 1), "E": (1, 0)}
    assert moves(system, (2, 1)) == {"S": (2, 0), "W": (1, 1)}
    assert system.size == 6


def test_moves_into_an_obstacle_do_not_exist() -> None:
    system = GridModel((3, 3), (0, 0), obstacles={"wall": [(1, 0, 1, 1)]}).transition_system()
    assert moves(system, (0, 0)) == {"N": (0, 1)}
    assert moves(system, (1, 2)) == {"E": (2, 2), "W": (0, 2)}
    assert (1, 0) not in system.states and (1, 1) not in system.states
    assert system.size == 7


def test_regions_include_their_corners_and_may_overlap() -> None:
    system = GridModel(
        (4, 4), (0, 0), regions={"p": [(0, 0, 1, 2)], "q": [(1, 1, 3, 1), (0, 3, 0, 3)]}
    ).transition_system()
    assert {cell for cell in system.states if "p" in label(system, cell)} == {(x, y) for x in (0, 1) for y in (0, 1, 2)}
    assert {cell for cell in system.states if "q" in label(system, cell)} == {(1, 1), (2, 1), (3, 1), (0, 3)}
    assert label(system, (1, 1)) == {"p", "q"}
    assert label(system, (3, 3)) == frozenset()


def test_every_move_costs_the_same() -> None:
    system = GridModel((2, 2), (0, 0), cost=0.25).transition_system()
    assert {system.step(0, action)[1] for action in ("N", "E")} == {0.25}


def test_the_propositions_are_the_regions_and_those_declared() -> None:
    model = GridModel(
        (2, 2), (0, 0), regions={"p": [(0, 0, 0, 0)]}, obstacles={"wall": []}, propositions=frozenset({"q"})
    )
    assert model.transition_system().propositions == {"p", "q"}


def test_a_grid_of_one_cell_has_no_moves() -> None:
    system = GridModel((1, 1), (0, 0), regions={"p": [(0, 0, 0, 0)]}).transition_system()
    assert (system.size, len(system.edges(0)), system.label(0)) == (1, 0, {"p"})


@pytest.mark.parametrize("seed", range(40))
def test_random_grids_agree_with_a_plain_walk_over_the_cells(seed: int) -> None:
    rng = random.Random(seed)
    width, height = rng.randint(1, 6), rng.randint(1, 6)

    def boxes() -> list[tuple[int, int, int, int]]:
        corners = []
        for _ in range(rng.randint(1, 2)):
            (x0, x1), (y0, y1) = (sorted(rng.randrange(n) for _ in range(2)) for n in (width, height))
            corners.append((x0, y0, x1, y1))
        return corners

    regions = {name: boxes() for name in rng.sample("pqr", rng.randint(0, 3))}
    obstacles = {name: boxes() for name in rng.sample("uv", rng.choice((0, 0, 1, 2)))}

    def within(cell: tuple[int, int], some: list[tuple[int, int, int, int]]) -> bool:
        return any(x0 <= cell[0] <= x1 and y0 <= cell[1] <= y1 for x0, y0, x1, y1 in some)

    cells = [(x, y) for x in range(width) for y in range(height)]
    free = {cell for cell in cells if not any(within(cell, some) for some in obstacles.values())}
    if not free:
        return
    start = rng.choice(sorted(free))
    system = GridModel((width, height), start, regions=regions, obstacles=obstacles).transition_system()
    assert set(system.states) == free and system.size == len(free)
    assert system.states[system.start] == start
    for cell in free:
        ends = {move: (cell[0] + dx, cell[1] + dy) for move, (dx, dy) in MOVES.items()}
        assert list(moves(system, cell).items()) == [(move, end) for move, end in ends.items() if end in free]
        assert label(system, cell) == {name for name, some in regions.items() if within(cell, some)}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"size": (0, 3)}, "size: must be at least 1 x 1, not 0 x 3"),
        ({"start": (3, 0)}, "start: [3, 0] lies outside the grid of 3 x 3 cells"),
        ({"start": (0, -1)}, "start: [0, -1] lies outside the grid of 3 x 3 cells"),
        ({"obstacles": {"wall": [(0, 0, 0, 2)]}}, "start: [0, 0] lies in obstacle 'wall'"),
        ({"cost": -1}, "cost: negative cost -1"),
        ({"regions": {"p": [(1, 1, 3, 1)]}}, "regions.p: box [1, 1, 3, 1] reaches outside the grid of 3 x 3 cells"),
        ({"regions": {"p": [(-1, 1, 1, 1)]}}, "regions.p: box [-1, 1, 1, 1] reaches outside the grid of 3 x 3 cells"),
        ({"obstacles": {"w": [(1, 1, 1, 3)]}}, "obstacles.w: box [1, 1, 1, 3] reaches outside the grid of 3 x 3 cells"),
        ({"regions": {"p": [(2, 0, 1, 0)]}}, "regions.p: box [2, 0, 1, 0] needs x0 <= x1 and y0 <= y1"),
    ],
)
def test_what_makes_no_sense_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError) as caught:
        GridModel(**{"size": (3, 3), "start": (0, 0)} | changes)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(("name", "message"), [("U", "'U' is a reserved word"), ("2p", "'2p' is not a name")])
def test_a_region_needs_a_name_that_formulas_can_mention(name: str, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        GridModel((2, 2), (0, 0), regions={name: [(0, 0, 0, 0)]})
