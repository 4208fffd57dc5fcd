"""Grid model: a mobile robot that moves north, south, east and west between cells (the paper's Example 1)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np

from prefplan.errors import ModelError
from prefplan.exact_costs import exact, in_common_unit
from prefplan.limits import available_memory, check_limits
from prefplan.models.costs import Cost, CostTable, by_name, check_costs_agree
from prefplan.models.transition_system import TransitionSystem
from prefplan.plan import OnDemand
from prefplan.text.forms import Form, check_fields
from prefplan.text.names import Names, check_names

MOVES = {"N": (0, 1), "S": (0, -1), "E": (1, 0), "W": (-1, 0)}

BYTES_A_CELL = 300
"""Approximate memory for building a grid, per cell."""

Cell = tuple[int, int]
"""x y."""

GridBox = tuple[int, int, int, int]
"""x0 y0 x1 y1, corners inclusive."""

Boxes = Annotated[
    Sequence[GridBox],
    Form("[x0, y0, x1, y1] in whole cells, or a list of such boxes", "a list of boxes [(x0, y0, x1, y1), ...]"),
]


@dataclass(frozen=True)
class Terrain:
    """Cells with their own cost of entering.

    Attributes:
        boxes: the cells.
        cost: cost of a move into one of them, >= 0.
    """

    boxes: Boxes
    cost: Cost


@dataclass(frozen=True)
class GridModel:
    """Cells (x, y) with (0, 0) at the lower left; a move off the grid or into an obstacle does not exist.

    Attributes:
        size: (width, height) in cells.
        start: initial cell.
        cost: cost of every move except those into a cell of a terrain, >= 0.
        terrain: by name; where two overlap, the last one counts.
        regions: boxes in which a proposition holds, by proposition; they may overlap.
        obstacles: boxes that cannot be entered; their names only appear in messages.
        propositions: further names that formulas may use, although they hold in no cell.

    Raises:
        ModelError: (on construction) for a box or start outside the grid, a start in an obstacle, an invalid name, or
            a negative cost. The message starts with the key as in a scenario file.
    """

    kind: ClassVar[str] = "grid"

    size: Annotated[tuple[int, int], Form("[width, height] in cells", "(width, height) in cells")]
    start: Annotated[tuple[int, int], Form("[x, y], the cell where the robot starts", "(x, y), a cell")]
    cost: Cost = 1
    regions: Mapping[str, Boxes] = field(default_factory=dict)
    obstacles: Mapping[str, Boxes] = field(default_factory=dict)
    propositions: Names = frozenset()
    terrain: Mapping[str, Terrain] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check that everything lies on the grid."""
        check_fields(self, ModelError)
        width, height = self.size
        if width < 1 or height < 1:
            raise ModelError(f"size: must be at least 1 x 1, not {width} x {height}")
        if not (0 <= self.start[0] < width and 0 <= self.start[1] < height):
            raise ModelError(f"start: {list(self.start)} lies outside the grid of {width} x {height} cells")
        ground = ((f"terrain.{name}.cost", terrain.cost) for name, terrain in self.terrain.items())
        check_costs_agree([("cost", self.cost), *ground])
        check_names(self.regions, where="regions")
        check_names(self.propositions, where="propositions")
        check_names(self.terrain, where="terrain")
        rough = {name: terrain.boxes for name, terrain in self.terrain.items()}
        areas = {"regions": self.regions, "obstacles": self.obstacles, "terrain": rough}
        named = [(kind, name, box) for kind in areas for name, boxes in areas[kind].items() for box in boxes]
        for kind, name, (x0, y0, x1, y1) in named:
            where = f"{kind}.{name}: box {[x0, y0, x1, y1]}"
            if x0 > x1 or y0 > y1:
                raise ModelError(f"{where} needs x0 <= x1 and y0 <= y1 (corners are inclusive)")
            if x0 < 0 or y0 < 0 or x1 >= width or y1 >= height:
                raise ModelError(f"{where} reaches outside the grid of {width} x {height} cells")
        for kind, name, (x0, y0, x1, y1) in named:
            if kind == "obstacles" and x0 <= self.start[0] <= x1 and y0 <= self.start[1] <= y1:
                raise ModelError(f"start: {list(self.start)} lies in obstacle {name!r}")

    @property
    def cost_names(self) -> tuple[str, ...]:
        """The names of the costs."""
        return tuple(by_name(self.cost))

    def transition_system(self) -> TransitionSystem:
        """Return the cells without obstacles, row by row, as a weighted transition system.

        Raises:
            ModelError: if the grid does not fit into free memory.
        """
        width, height = self.size
        if width * height * BYTES_A_CELL > available_memory():
            raise ModelError(f"size: {width} x {height} cells need more memory than is free")
        check_limits(width * height * BYTES_A_CELL)
        # A border of obstacles, so that no move leads off the grid.
        bordered = np.pad(np.ones((height, width), dtype=bool), 1)
        free = bordered[1:-1, 1:-1]
        for boxes in self.obstacles.values():
            _fill(free, boxes, False)
        cells, (exists, targets) = np.flatnonzero(free), _moves(bordered)
        # The terrain of each cell by its number from 1, 0 for none.
        ground = np.zeros((height, width), dtype=np.min_scalar_type(len(self.terrain)))
        for k, terrain in enumerate(self.terrain.values(), start=1):
            _fill(ground, terrain.boxes, k)
        ground = ground[free]
        check_limits()
        entered = ground[targets]
        check_limits()
        every = [self.cost, *(terrain.cost for terrain in self.terrain.values())]
        costs = {name: in_common_unit([exact(by_name(cost)[name]) for cost in every]) for name in self.cost_names}
        tables = [CostTable(name, counts[entered], unit) for name, (counts, unit) in costs.items()]
        check_limits()
        offsets = np.zeros(len(cells) + 1, dtype=np.int64)
        np.cumsum(exists.sum(axis=1), out=offsets[1:])
        labels, label_sets = self._labels(free)
        check_limits()
        return TransitionSystem(
            states=OnDemand(len(cells), lambda i: divmod(int(cells[i]), width)[::-1]),
            start=int(np.searchsorted(cells, self.start[1] * width + self.start[0])),
            offsets=offsets,
            targets=targets,
            actions=np.broadcast_to(np.arange(4, dtype=np.int32), exists.shape)[exists],
            costs=tuple(tables),
            labels=labels,
            action_names=tuple(MOVES),
            label_sets=label_sets,
            propositions=self.valid_propositions,
        )

    @property
    def valid_propositions(self) -> frozenset[str]:
        """Every name that a formula may use."""
        return frozenset(self.regions) | self.propositions

    def _labels(self, free: np.ndarray) -> tuple[np.ndarray, tuple[frozenset[str], ...]]:
        """Return (S,) each free cell's label as an index, and the distinct labels."""
        label = np.zeros(free.shape, dtype=np.int32)
        sets: list[frozenset[str]] = [frozenset()]
        for name, boxes in self.regions.items():
            within = np.zeros(free.shape, dtype=bool)
            _fill(within, boxes, True)
            for old in np.flatnonzero(np.bincount(label[within])).tolist():
                label[within & (label == old)] = len(sets)
                sets.append(sets[old] | {name})
            check_limits()
        labels = label[free]
        used = np.flatnonzero(np.bincount(labels, minlength=len(sets)))
        place = np.zeros(len(sets), dtype=np.int32)
        place[used] = np.arange(len(used))
        return place[labels], tuple(sets[i] for i in used)


def _moves(bordered: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (S, 4) bool, whether each move exists in each free cell, and (E,) int32, where these moves lead, in order.

    `bordered` are the (height + 2, width + 2) cells with a border of obstacles.
    """
    free = bordered[1:-1, 1:-1]
    count, (height, width) = np.count_nonzero(free), free.shape
    number = np.zeros(bordered.shape, dtype=np.int32)
    number[1:-1, 1:-1][free] = np.arange(count)
    exists, targets = np.empty((count, 4), dtype=bool), np.empty((count, 4), dtype=np.int32)
    for k, (dx, dy) in enumerate(MOVES.values()):
        check_limits()
        ends = np.s_[1 + dy : 1 + dy + height, 1 + dx : 1 + dx + width]
        exists[:, k], targets[:, k] = bordered[ends][free], number[ends][free]
    check_limits()
    return exists, targets[exists]


def _fill(cells: np.ndarray, boxes: Sequence[GridBox], value: int) -> None:
    """Set the cells in some boxes of a (height, width) array."""
    for x0, y0, x1, y1 in boxes:
        cells[y0 : y1 + 1, x0 : x1 + 1] = value
