"""Collision-free paths in the plane of two sliding joints."""

from __future__ import annotations

import numpy as np
import pytest

from sim.errors import BlockedError, SimulationError
from sim.motion.planning import EDGE_STEPS_M, MotionPlanner, Touches

START, GOAL = np.array([-0.8, 0.0]), np.array([0.8, 0.0])


def planner(seed: int = 0) -> MotionPlanner:
    return MotionPlanner(np.array([[-1.0, 1.0], [-1.0, 1.0]]), np.ones(2), seed=seed)


def wall(*, half: float) -> Touches:
    """Return a wall 10 cm thick across the middle, with this half length, m."""
    return lambda q: {"wall"} if abs(q[0]) < 0.05 and abs(q[1]) < half else set()


def densely(path: np.ndarray) -> np.ndarray:
    return np.vstack([np.linspace(a, b, 200) for a, b in zip(path, path[1:], strict=False)])


@pytest.mark.parametrize("step", EDGE_STEPS_M)
@pytest.mark.parametrize("seed", range(5))
def test_a_path_leads_round_a_wall_and_is_hardly_longer_than_it_must_be(seed: int, step: float) -> None:
    path = planner(seed).plan(START, GOAL, touches := wall(half=0.5), step=step)
    assert np.array_equal(path[[0, -1]], [START, GOAL])
    samples = densely(path)
    inside = np.array([bool(touches(q)) for q in samples])
    steps = np.linalg.norm(np.diff(samples, axis=0), axis=1)
    cuts = np.split(np.where(inside[1:], steps, 0.0), np.flatnonzero(~inside[1:]))
    assert max(cut.sum() for cut in cuts) < step
    shortest = 2 * np.hypot(0.75, 0.5) + 0.1
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).sum() < 1.15 * shortest


def test_with_nothing_in_the_way_the_path_is_straight() -> None:
    path = planner().plan(START, GOAL, lambda q: set())
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).sum() == pytest.approx(1.6)


@pytest.mark.parametrize("off", [(0.19, 0.0), (0.2, 1.0)])
def test_a_path_may_begin_and_end_at_the_ends_of_the_joints(off: tuple[float, float]) -> None:
    """The first joint begins nearer to its limit than paths are elsewhere."""
    goal = GOAL + off
    path = planner().plan(-goal, goal, wall(half=0.5))
    assert np.array_equal(path[[0, -1]], [-goal, goal])


def test_from_beyond_the_ends_of_the_joints_no_path_is_looked_for() -> None:
    with pytest.raises(SimulationError, match="beyond the position limits"):
        planner().plan(START - [1.0, 0.0], GOAL, lambda q: set())


def test_what_an_end_touches_when_it_is_looked_at_again_is_named() -> None:
    looks: list[bool] = []

    def touches(q: np.ndarray) -> set[str]:
        looks.append(bool(np.array_equal(q, GOAL)))
        return {"edge"} if sum(looks) > 1 and looks[-1] else set()

    with pytest.raises(BlockedError, match="no path past edge was found"):
        planner().plan(START, GOAL, touches)


def test_the_seed_alone_decides_the_path() -> None:
    first, again, other = (planner(seed).plan(START, GOAL, wall(half=0.5)) for seed in (3, 3, 4))
    assert np.array_equal(first, again)
    assert first.shape != other.shape or not np.allclose(first, other)


@pytest.mark.parametrize(
    ("touches", "blocker", "words"),
    [
        pytest.param(wall(half=2.0), "wall", "no path past wall was found", id="no path"),
        pytest.param(lambda q: {"lid"} if q[0] > 0.7 else set(), "lid", "touch lid at its goal", id="goal"),
        pytest.param(lambda q: {"box"} if q[0] < -0.7 else set(), "box", "touch box at its start", id="start"),
    ],
)
def test_without_a_path_what_is_in_the_way_is_named(touches: Touches, blocker: str, words: str) -> None:
    with pytest.raises(BlockedError, match=words) as raised:
        planner().plan(START, GOAL, touches)
    assert raised.value.by == (blocker,)


def test_narrow_passages_such_as_those_out_of_a_shelf_are_found() -> None:
    """Six joints leave a tube of 24 cm, from the middle to where all is free."""

    def touches(q: np.ndarray) -> set[str]:
        return {"shelf"} if q[0] < 0.5 and np.abs(q[1:]).max() > 0.12 else set()

    start, goal = np.zeros(6), np.full(6, 0.7)
    for seed in range(5):
        joints = MotionPlanner(np.tile([-1.0, 1.0], (6, 1)), np.ones(6), seed=seed, searches=1)
        path = joints.plan(start, goal, touches)
        assert np.array_equal(path[[0, -1]], [start, goal])
