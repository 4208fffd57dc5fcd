"""Random scenes: scenario files with walls, shelves, stacks and objects of all sizes, often close together."""

from __future__ import annotations

import numpy as np

from prefplan.exact_costs import INT64_LIMIT

NEAR_M, FAR_M, ASIDE_RAD = 0.25, 0.82, 1.2
"""Locations are drawn at distances from the base between these two, and within this angle of straight ahead."""

PITCHES_M = (0.07, 0.16)
"""Bounds on a scene's pitch, the least distance between the centres of two locations along x or y."""

TO_OBSTACLES_M = (0.03, 0.1)
"""Bounds on a scene's least distance of the centre of a location from the circle around an obstacle."""

MASSES_KG = (0.004, 3.0)
"""Bounds on the mass of an object."""

SHELF_DEPTH_M, SHELF_WIDTH_M = 0.24, 0.5

BOARDS_M = (0.11, 0.3)
"""Bounds on the height of a shelf's upper board; the lower one lies on the table."""

TRIALS = 1000
"""Attempts to place one location or obstacle; if all fail, the whole scene is drawn again."""


class NoRoomError(Exception):
    """A scene has no room for another location or obstacle, or more states than the planner can number."""


class RandomScene:
    """A random scene, as the lines of its scenario file."""

    def __init__(self, rng: np.random.Generator) -> None:
        """Draw a scene at random."""
        self._rng = rng
        self._taken: list[tuple[np.ndarray, np.ndarray]] = []
        """Centres and half sides of the boxes that are occupied, m."""
        self._pitch, self._to_obstacles = rng.uniform(*PITCHES_M), rng.uniform(*TO_OBSTACLES_M)
        self.fixtures: list[str] = []
        self.locations: dict[str, str] = {}
        self.objects: dict[str, str] = {}
        self.tasks: list[str] = []
        count = int(rng.integers(4, 15))
        if rng.random() < 1 / 3:
            self._add_shelf()
        if rng.random() < 1 / 3:
            self._add_grid(int(rng.integers(2, 4)), int(rng.integers(2, 4)))
        for k in range(rng.integers(4)):
            self._add_obstacle(f"wall{k}")
        for k in range(max(1, count + int(rng.integers(1, 4)) - len(self.locations))):
            self.locations[f"p{k}"] = self._at(self._free(np.zeros(2), self._pitch / 2))
        grounded = [str(place) for place in rng.permutation([*self.locations])]
        stacks = {f"top{k}": grounded[k] for k in range(rng.integers(3))}
        self.locations |= {top: f'on = ["{base}"]' for top, base in stacks.items()}
        starts = grounded[: min(count, len(grounded) - 1)]
        if (len(self.locations) + 1) ** (len(starts) + 1) >= INT64_LIMIT:
            raise NoRoomError
        if stacks and rng.random() < 1 / 2:
            starts[-1] = "top0"
        for k, start in enumerate(starts):
            self.objects[f"o{k}"] = f'start = "{start}", {self._shape()}, mass = {self._mass():.3g}'
        self._add_tasks([str(place) for place in rng.permutation([*self.locations]) if place not in starts])

    def text(self) -> str:
        """Return the scenario file."""

        def table(name: str, entries: dict[str, str]) -> list[str]:
            return ["", f"[model.{name}]", *(f"{key} = {{ {value} }}" for key, value in entries.items())]

        lines = ["[model]", 'kind = "manipulation"', 'start = "home"']
        lines += ["costs = { transit = 3, grasp = 1, transport = 5, release = 1 }"]
        lines += ["", "[model.fixtures]", *self.fixtures] if self.fixtures else []
        lines += table("locations", self.locations) + table("objects", self.objects)
        for k, formula in enumerate(self.tasks):
            lines += ["", "[[tasks]]", f'name = "task{k}"', f'formula = "{formula}"']
        return "\n".join([*lines, "", "[preference]", 'kind = "order"', ""])

    @staticmethod
    def _at(point: np.ndarray) -> str:
        return f"at = [{', '.join(f'{value:.3f}' for value in point)}]"

    def _free(self, half: np.ndarray, margin: float) -> np.ndarray:
        """Draw a centre for a box with these half sides, `margin` away from everything, and mark it occupied, m."""
        for _ in range(TRIALS):
            radius = np.sqrt(self._rng.uniform(NEAR_M**2, FAR_M**2))
            angle = self._rng.uniform(-ASIDE_RAD, ASIDE_RAD)
            point = radius * np.array([np.cos(angle), np.sin(angle)])
            if all(np.any(abs(point - middle) > half + margin + sides) for middle, sides in self._taken):
                self._taken.append((point, half + margin))
                return point
        raise NoRoomError

    def _add_shelf(self) -> None:
        """Add a shelf on one side that is open towards the arm, with a location on each board."""
        side = self._rng.choice([-1, 1])
        middle, board = np.array([0.62, 0.3 * side]), self._rng.uniform(*BOARDS_M)
        size = f"[{SHELF_DEPTH_M}, {SHELF_WIDTH_M}, {board + 0.2:.3f}]"
        self.fixtures.append(
            f'shelf = {{ kind = "shelf", {self._at(np.array([*middle, 0.0]))}, size = {size}, yaw = 180, '
            f"boards = [0.0, {board:.3f}] }}"
        )
        front = middle - [0.07, 0]
        self.locations["low"] = self._at(front + [0, 0.09])
        self.locations["high"] = self._at(np.array([*front, board]))
        self._taken.append((middle, np.array([SHELF_DEPTH_M, SHELF_WIDTH_M]) / 2 + 0.08))

    def _add_grid(self, rows: int, columns: int) -> None:
        """Add locations side by side, in rows along x and columns along y."""
        extent = np.array([rows - 1, columns - 1]) * self._pitch
        first = self._free(extent / 2, self._pitch / 2) - extent / 2
        for row, column in np.ndindex(rows, columns):
            self.locations[f"r{row}c{column}"] = self._at(first + self._pitch * np.array([row, column]))

    def _add_obstacle(self, name: str) -> None:
        """Add a wall or a block with a random yaw."""
        # The centre of a box of whole centimetres is written exactly, in millimetres.
        size = np.round(self._rng.uniform([0.02, 0.05, 0.05], [0.1, 0.25, 0.5]), 2)
        half = np.full(2, np.hypot(*size[:2]) / 2)
        # Locations keep half a pitch from what is taken.
        point = self._free(half, self._to_obstacles - self._pitch / 2)
        size_text = ", ".join(f"{side:.3f}" for side in size)
        self.fixtures.append(
            f'{name} = {{ kind = "box", {self._at(np.array([*point, size[2] / 2]))}, size = [{size_text}], '
            f"yaw = {self._rng.uniform(0, 180):.0f} }}"
        )

    def _shape(self) -> str:
        """Return a cube, a box or a cylinder that the hand can span."""
        kind = self._rng.choice(["cube", "box", "cylinder"])
        low, high = {
            "cube": ([0.03], [0.06]),
            "box": ([0.03, 0.03, 0.03], [0.06, 0.1, 0.1]),
            "cylinder": ([0.03, 0.03], [0.06, 0.1]),
        }[kind]
        sides = [f"{side:.3f}" for side in self._rng.uniform(low, high)]
        size = sides[0] if kind == "cube" else f"[{', '.join(sides)}]"
        return f'kind = "{kind}", size = {size}'

    def _mass(self) -> float:
        return float(np.exp(self._rng.uniform(*np.log(MASSES_KG))))

    def _add_tasks(self, free: list[str]) -> None:
        """Add two or three tasks: move an object to a free location, and in a third of them another one after it."""
        moved = self._rng.permutation([*self.objects])
        for k in range(min(int(self._rng.integers(2, 4)), len(moved))):
            goal = free[k % len(free)]
            formula = f"F {moved[k]}_{goal}"
            if self._rng.random() < 1 / 3:
                formula = f"F ({moved[k]}_{goal} & X F {moved[(k + 1) % len(moved)]}_{goal})"
            self.tasks.append(formula)


def scene_text(seed: int, number: int) -> str:
    """Return the scenario file of a scene, a pure function of the seed and the number."""
    for attempt in range(TRIALS):
        try:
            return RandomScene(np.random.default_rng([seed, number, attempt])).text()
        except NoRoomError:
            continue
    raise AssertionError("no scene was drawn")
