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


def test_every_move_costs_the_same_and_declared_propositions_may_be_used() -> None:
    regions, obstacles = {"p": [(0, 0, 0, 0)]}, {"wall": []}
    model = GridModel((2, 2), (0, 0), 0.25, regions=regions, obstacles=obstacles, propositions=frozenset({"q"}))
    system = model.transition_system()
    assert {system.step(0, action)[1] for action in ("N", "E")} == {0.25}
    assert system.propositions == {"p", "q"}


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

    def within(cell: tuple[int, int], boxes: list[tuple[int, int, int, int]]) -> bool:
        return any(x0 <= cell[0] <= x1 and y0 <= cell[1] <= y1 for x0, y0, x1, y1 in boxes)

    cells = [(x, y) for x in range(width) for y in range(height)]
    free = {cell for cell in cells if not any(within(cell, wall) for wall in obstacles.values())}
    if not free:
        return
    start = rng.choice(sorted(free))
    system = GridModel((width, height), start, regions=regions, obstacles=obstacles).transition_system()
    assert set(system.states) == free and system.size == len(free)
    assert system.states[system.start] == start
    for cell in free:
        ends = {move: (cell[0] + dx, cell[1] + dy) for move, (dx, dy) in MOVES.items()}
        assert list(moves(system, cell).items()) == [(move, end) for move, end in ends.items() if end in free]
        assert label(system, cell) == {name for name, region in regions.items() if within(cell, region)}


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
        ({"regions": {"U": []}}, "regions: 'U' is a reserved word"),
        ({"regions": {"2p": []}}, "regions: '2p' is not a name"),
    ],
)
def test_what_makes_no_sense_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError) as caught:
        GridModel(**{"size": (3, 3), "start": (0, 0)} | changes)
    assert str(caught.value).startswith(message)
