"""Grid model: a mobile robot that moves N S E W between cells (the paper's Example 1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from prefplan.errors import ModelError
from prefplan.exact_costs import Number, exact, in_common_unit
from prefplan.limits import available_memory
from prefplan.models.on_demand import OnDemand
from prefplan.models.transition_system import TransitionSystem, check_names

MOVES = {"N": (0, 1), "S": (0, -1), "E": (1, 0), "W": (-1, 0)}

BYTES_A_CELL = 300
"""Memory that building a grid takes for each cell, about."""

Box = tuple[int, int, int, int]
"""x0 y0 x1 y1, corners inclusive."""


@dataclass(frozen=True)
class GridModel:
    """Cells (x, y) with (0, 0) at the lower left; a move off the grid or into an obstacle does not exist.

    Attributes:
        size: (width, height) in cells.
        start: first cell.
        cost: of every move.
        regions: boxes in which a proposition holds, by proposition; they may overlap.
        obstacles: boxes that cannot be entered; their names are for the reader.
        propositions: names that may be used in formulas although no cell carries them.

    Raises:
        ModelError: (on construction) for a box or start outside the grid, a start in an obstacle, or a negative cost.
            The message starts with the key as in a scenario file.
    """

    size: tuple[int, int]
    start: tuple[int, int]
    cost: Number = 1
    regions: Mapping[str, Sequence[Box]] = field(default_factory=dict)
    obstacles: Mapping[str, Sequence[Box]] = field(default_factory=dict)
    propositions: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        """Check that everything lies on the grid."""
        width, height = self.size
        if width < 1 or height < 1:
            raise ModelError(f"size: must be at least 1 x 1, not {width} x {height}")
        if not (0 <= self.start[0] < width and 0 <= self.start[1] < height):
            raise ModelError(f"start: {list(self.start)} lies outside the grid of {width} x {height} cells")
        if exact(self.cost, "cost") < 0:
            raise ModelError(f"cost: negative cost {self.cost}")
        check_names(self.regions, where="regions")
        check_names(self.propositions, where="propositions")
        for kind, boxes in (("regions", self.regions), ("obstacles", self.obstacles)):
            for name, boxes_of in boxes.items():
                for box in boxes_of:
                    _check_box(f"{kind}.{name}", box, self.size)
        for name, boxes_of in self.obstacles.items():
            if any(x0 <= self.start[0] <= x1 and y0 <= self.start[1] <= y1 for x0, y0, x1, y1 in boxes_of):
                raise ModelError(f"start: {list(self.start)} lies in obstacle {name!r}")

    def transition_system(self) -> TransitionSystem:
        """Return the cells that are no obstacle, row by row, as a weighted transition system.

        Raises:
            ModelError: if the grid is larger than the memory that is free.
        """
        width, height = self.size
        if width * height * BYTES_A_CELL > available_memory():
            raise ModelError(f"size: {width} x {height} cells need more memory than is free")
        free = np.ones((height, width), dtype=bool)
        for boxes in self.obstacles.values():
            for x0, y0, x1, y1 in boxes:
                free[y0 : y1 + 1, x0 : x1 + 1] = False
        number = np.cumsum(free.ravel()).reshape(free.shape) - 1
        y, x = np.nonzero(free)
        exists, target = [], []
        for dx, dy in MOVES.values():
            nx, ny = x + dx, y + dy
            inside = (nx >= 0) & (nx < width) & (ny >= 0) & (ny < height)
            nx, ny = np.where(inside, nx, 0), np.where(inside, ny, 0)
            exists.append(inside & free[ny, nx])
            target.append(number[ny, nx])
        there = np.stack(exists, axis=1)
        count, unit = in_common_unit([exact(self.cost)])
        labels, label_sets = self._labels(free)
        return TransitionSystem(
            states=OnDemand(len(x), lambda i: (int(x[i]), int(y[i]))),
            start=int(number[self.start[1], self.start[0]]),
            offsets=np.concatenate([[0], np.cumsum(there.sum(axis=1))]).astype(np.int64),
            targets=np.stack(target, axis=1)[there].astype(np.int32),
            actions=np.tile(np.arange(4, dtype=np.int32), (len(x), 1))[there],
            costs=np.full(int(there.sum()), count[0], dtype=count.dtype),
            unit=unit,
            labels=labels,
            action_names=tuple(MOVES),
            label_sets=label_sets,
            propositions=frozenset(self.regions) | self.propositions,
        )

    def _labels(self, free: np.ndarray) -> tuple[np.ndarray, tuple[frozenset[str], ...]]:
        """Return each cell's label as an index, and the distinct labels."""
        label = np.zeros(free.shape, dtype=np.int64)
        sets: list[frozenset[str]] = [frozenset()]
        for name, boxes in self.regions.items():
            within = np.zeros(free.shape, dtype=bool)
            for x0, y0, x1, y1 in boxes:
                within[y0 : y1 + 1, x0 : x1 + 1] = True
            for old in np.unique(label[within]):
                label[within & (label == old)] = len(sets)
                sets.append(sets[old] | {name})
        used, labels = np.unique(label[free], return_inverse=True)
        return labels.astype(np.int32), tuple(sets[i] for i in used)


def _check_box(where: str, box: Box, size: tuple[int, int]) -> None:
    x0, y0, x1, y1 = box
    if x0 > x1 or y0 > y1:
        raise ModelError(f"{where}: box {list(box)} needs x0 <= x1 and y0 <= y1 (corners are inclusive)")
    if x0 < 0 or y0 < 0 or x1 >= size[0] or y1 >= size[1]:
        raise ModelError(f"{where}: box {list(box)} reaches outside the grid of {size[0]} x {size[1]} cells")
