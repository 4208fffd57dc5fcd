"""Places of labels on maps: apart, inside the frame, and near what they name."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from experiments.figures.label_placement import AREA, PATH, gap, place

FRAME = np.array([0.0, 0.0, 300.0, 300.0])


def box(x: float, y: float, width: float, height: float) -> np.ndarray:
    return np.array([x, y, x + width, y + height])


def overlap(a: np.ndarray, b: np.ndarray) -> bool:
    return bool((a[:2] < b[2:]).all() and (b[:2] < a[2:]).all())


@pytest.mark.parametrize("seed", range(4))
def test_labels_lie_apart_in_the_frame_and_beside_marks(seed: int) -> None:
    rng = np.random.default_rng(seed)
    corners = rng.uniform(0, 280, size=(14, 2))
    sizes = np.array([(rng.uniform(20, 110), 12) for _ in corners])
    targets, inside = np.array([box(x, y, 20, 20) for x, y in corners]), [i % 2 == 0 for i in range(len(corners))]
    found = [rectangle for rectangle in place(sizes, targets, inside, FRAME, [], line=10) if rectangle is not None]
    assert len(found) == len(corners)
    assert not any(overlap(a, b) for a, b in combinations(found, 2))
    for rectangle, size, target, may in zip(found, sizes, targets, inside, strict=True):
        assert (rectangle[:2] >= 0).all() and (rectangle[2:] <= 300).all()
        assert rectangle[2:] - rectangle[:2] == pytest.approx(size)
        assert may or not overlap(rectangle, target)


def test_a_name_keeps_off_the_path_and_lies_in_its_area_if_there_is_space() -> None:
    area = box(100, 100, 80, 60)
    path = np.stack([np.linspace(0, 300, 100), np.full(100, 150.0)], axis=1)
    obstacles = [(area, AREA), *((np.array([*point, *point]), PATH) for point in path)]
    (found,) = place(np.array([(40, 12)]), area[None], [True], FRAME, obstacles, line=10)
    assert found is not None
    assert gap(found[None], area)[0] == 0 and (found[:2] >= area[:2]).all() and (found[2:] <= area[2:]).all()
    assert not found[1] < 150 < found[3]


def test_a_label_without_space_is_left_out() -> None:
    sizes, targets = np.array([(300, 200), (200, 150)]), np.array([box(0, 0, 9, 9), box(50, 50, 90, 90)])
    assert sum(rectangle is None for rectangle in place(sizes, targets, [True, True], FRAME, [], line=10)) == 1
