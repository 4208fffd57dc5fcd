"""Maps on which plans are drawn: the common part of those of grids and of graphs."""

import textwrap
from collections import defaultdict
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon
from matplotlib.text import Text

from experiments.figures.figures import POINTS_PER_INCH
from experiments.figures.label_placement import AREA, DOT, PATH, Obstacle, gap, place
from experiments.figures.trail import Trail
from prefplan import Ledger, Plan, Problem

AREAS = ("#77aadd", "#ee8866", "#eedd88", "#ffaabb", "#99ddff", "#44bb99", "#bbcc33", "#aaaa00", "#dddddd")
"""Colours of regions, used in turn: `light` of P. Tol, "Colour Schemes", SRON technical note, 2021."""

PATH_COLOR, GOOD, START_COLOR = "#222255", "#117733", "#bb5566"
"""Colours of the path, of satisfied tasks and of the start, suited to colour-blind readers."""

SMALL_FONT_SIZE_PT = 7.5
"""Size of text on a map in a panel, points."""

MOST_LETTERS = 20
"""Greatest number of letters in a line of task names."""

LEADER = 0.7
"""Distance from which on a label is joined to what it names by a leader line, in heights of a text line."""

PAD_PX = 2.0
"""Empty border of a label, px."""

START_SIZE = 1.2
"""Size of the start's dot, relative to that of a satisfied task."""

MOST_SAMPLES = 300
"""Approximate number of points of a path that labels should not cover."""

THIN: dict[str, Any] = {"color": "#555555", "linewidth": 0.7}
"""Style of leader lines."""

SHEET = {"boxstyle": "round,pad=0.12", "facecolor": "white", "alpha": 0.8, "linewidth": 0}
"""Background of text on a map."""


class Named(NamedTuple):
    """Text that names something on a map.

    Attributes:
        kind: `name`, `terrain` or `task`.
        target: (4,) rectangle that is named.
        inside: whether the text may lie in the rectangle.
        state: the state that is named, if any; its name is left out where a task is satisfied there.
    """

    text: str
    kind: str
    target: np.ndarray
    inside: bool
    state: Any = None


def _text(axes: Axes, text: str, kind: str, font_size: float) -> Text:
    style: dict[str, Any] = {"color": GOOD, "weight": "bold", "zorder": 6} if kind == "task" else {"zorder": 4}
    if kind == "terrain":
        kind, style["style"] = "name", "italic"
    found = axes.text(0, 0, text, fontsize=font_size, va="bottom", bbox=SHEET, gid=kind, parse_math=False, **style)
    found.set_in_layout(False)
    return found


def square(middle: Sequence[float] | np.ndarray, radius: float) -> np.ndarray:
    """Return the (4,) rectangle around a circle."""
    return np.array([*middle, *middle]) + radius * np.array([-1, -1, 1, 1])


class PlanMap:
    """A map on which plans of a problem are drawn.

    Attributes:
        problem: the problem of the plans.
        size: width and height in units of the map; its lower left corner is (-0.5, -0.5).
        mark: radius of the dot of a satisfied task, in the same units.
        named: what has a name, besides tasks.
        unnamed: (4,) rectangles of areas without a name.
        path_width: width of a path's line, points.
    """

    problem: Problem
    size: tuple[float, float]
    mark: float
    named: list[Named]
    unnamed: Sequence[np.ndarray] = ()
    path_width: float

    def trail(self, plan: Plan) -> Trail:
        """Return the path of a plan."""
        raise NotImplementedError

    def _draw_ground(self, axes: Axes) -> None:
        """Draw the background, which is the same for every plan."""
        raise NotImplementedError

    def draw(self, axes: Axes, plan: Plan) -> None:
        """Draw the map with a plan: the path with its direction, the start and where tasks are satisfied; no text."""
        right, top = np.array(self.size) - 0.5
        axes.set(aspect="equal", xlim=(-0.5, right), ylim=(-0.5, top), xticks=[], yticks=[])
        axes.patch.set_gid("ground")
        axes.spines[:].set_visible(True)
        self._draw_ground(axes)
        trail = self.trail(plan)
        axes.plot(
            *trail.line.T, color=PATH_COLOR, linewidth=self.path_width, solid_joinstyle="round", zorder=3, gid="path"
        )
        for x, y, dx, dy in trail.arrows:
            ahead, aside = self.mark * np.array([dx, dy]), 0.7 * self.mark * np.array([-dy, dx])
            corners = np.array([x, y]) + [ahead, aside - 0.8 * ahead, -aside - 0.8 * ahead]
            axes.add_patch(Polygon(corners, closed=True, facecolor=PATH_COLOR, linewidth=0, zorder=3, gid="arrow"))
        dot: dict[str, Any] = {"edgecolor": "white", "linewidth": 0.6, "zorder": 5}
        start, size = tuple(trail.states[0]), START_SIZE * self.mark
        axes.add_patch(Circle(start, size, facecolor=START_COLOR, gid="start", **dot))
        for step in self.goals(plan):
            axes.add_patch(Circle(tuple(trail.states[step]), self.mark, facecolor=GOOD, gid="goal", **dot))

    def label(self, axes: Axes, plan: Plan, *, font_size: float = SMALL_FONT_SIZE_PT) -> None:
        """Write names on the map, whose axes must have their final position.

        No label overlaps another one or leaves the map; a label for which there is no space is omitted.
        """
        path, goals = self.trail(plan).states, self.goals(plan)
        reached = [plan.states[step] for step in goals]
        named = [one for one in self.named if one.state is None or one.state not in reached]
        for step, tasks in goals.items():
            lines = textwrap.fill(", ".join(tasks), MOST_LETTERS, break_long_words=False)
            named.append(Named(lines, "task", square(path[step], self.mark), False))
        sampled = path[:: max(1, len(path) // MOST_SAMPLES)]
        points = np.concatenate([sampled, (sampled[1:] + sampled[:-1]) / 2])
        shunned = [(square(path[0], START_SIZE * self.mark), DOT), *((area, AREA) for area in self.unnamed)]
        shunned += [(np.array([*point, *point]), PATH) for point in points]
        # What one label names should not be covered by another label.
        shunned += [(one.target, AREA if one.inside else DOT) for one in named]
        self._write(axes, named, shunned, font_size)

    def _write(self, axes: Axes, named: Sequence[Named], obstacles: Sequence[Obstacle], font_size: float) -> None:
        """Write names where there is space, off obstacles as far as possible, with leader lines to distant targets."""
        to_pixels, to_map = axes.transData.transform, axes.transData.inverted().transform
        texts = [_text(axes, one.text, one.kind, font_size) for one in named]
        sizes = np.array([text.get_window_extent().size for text in texts]).reshape(-1, 2) + 2 * PAD_PX
        targets = np.array([to_pixels(one.target.reshape(2, 2)).ravel() for one in named]).reshape(-1, 4)
        shunned = [(to_pixels(rectangle.reshape(2, 2)).ravel(), cost) for rectangle, cost in obstacles]
        frame = np.array(axes.get_window_extent().extents) + [1, 1, -1, -1]
        line = font_size * axes.figure.dpi / POINTS_PER_INCH
        places = place(sizes, targets, [one.inside for one in named], frame, shunned, line=line)
        for text, rectangle, target in zip(texts, places, targets, strict=True):
            if rectangle is None:
                text.remove()
                continue
            text.set_position(tuple(to_map(rectangle[:2] + PAD_PX)))
            if gap(rectangle[None], target)[0] > LEADER * line:
                middle = (target[:2] + target[2:]) / 2
                ends = np.array([np.clip(middle, rectangle[:2], rectangle[2:]), middle])
                axes.plot(*to_map(ends).T, zorder=3.5, gid="leader", **THIN)

    def goals(self, plan: Plan) -> dict[int, list[str]]:
        """Return the tasks that a plan satisfies, by the number of actions done when they are."""
        found: dict[int, list[str]] = defaultdict(list)
        for task, step in Ledger.of_plan(self.problem, plan).satisfied.items():
            if step is not None:
                found[step].append(self.problem.display.task(task))
        return dict(found)
