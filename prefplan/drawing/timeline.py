"""A plan as a timeline along the cost spent: its actions, and when each task is satisfied."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import groupby

from prefplan.drawing import svg
from prefplan.exact_costs import Number
from prefplan.text.layout import number

WIDTH_PX = 760.0
LINE_PX = 22.0
"""Height of a task's row, and of a line of text."""

NAME_PX = 150.0
"""Greatest width of the tasks' names."""

END_PX = 70.0
"""Width at the right for the cost of the last task."""

BLOCK_PX = (26.0, 150.0)
"""Height of the row of actions: with text across, and greatest height with text upwards."""

NARROWEST_PX = 13.0
"""Least width of a block that text upwards fits into."""

PARTED_PX = 3.0
"""Least width of a block that is parted from the next by a white line."""

TICKS = 8
"""Most ticks of the axis, about."""


def timeline(
    actions: Sequence[str],
    action_costs: Sequence[Number],
    task_costs: Mapping[str, Number | None],
    *,
    title: str,
    cost: str,
) -> str:
    """Return a plan as SVG.

    Args:
        actions: (K,) in order.
        action_costs: (K,) cost of each.
        task_costs: cost at which each task is satisfied, by name; None if it never is.
        title: above the picture.
        cost: name of the cost.
    """
    total = float(sum(action_costs))
    left = min(NAME_PX, svg.LETTER_PX * max(map(len, ("actions", *task_costs)))) + 12
    scale = (WIDTH_PX - left - END_PX) / total if total else 0.0
    top = LINE_PX + 6
    height, row = _action_row(_blocks(actions, action_costs), left=left, y=top, scale=scale)
    below = top + height + 6
    parts = [svg.text(4, 17, title, font_weight="bold"), *row]
    for k, (task, end) in enumerate(task_costs.items()):
        parts += _task_row(task, end, left=left, right=left + scale * total, y=below + LINE_PX * k, scale=scale)
    base = below + LINE_PX * len(task_costs) + 2
    return svg.picture(WIDTH_PX, base + LINE_PX + 6, [*parts, *_axis(total, cost, left=left, y=base, scale=scale)])


def _action_row(
    blocks: Sequence[tuple[str, str, float]], *, left: float, y: float, scale: float
) -> tuple[float, list[str]]:
    """Return the height of the row of actions, and a block for each; text that fits across no block runs upwards."""
    widths = [svg.LETTER_PX * len(words) + 12 for words, _, _ in blocks]
    sizes = [scale * cost for _, _, cost in blocks]
    across = all(wide <= size for wide, size in zip(widths, sizes, strict=True))
    upwards = max((wide for wide, size in zip(widths, sizes, strict=True) if size >= NARROWEST_PX), default=0.0)
    height = BLOCK_PX[0] if across else min(BLOCK_PX[1], max(upwards, BLOCK_PX[0]))
    middle = y + height / 2 + 4
    parts = [svg.text(4, middle, "actions", fill=svg.SOFT)]
    kinds = list(dict.fromkeys(_kind(action) for _, action, _ in blocks))
    spent = 0.0
    for (words, action, cost), size in zip(blocks, sizes, strict=True):
        x, center = left + scale * spent, left + scale * spent + size / 2
        colour = svg.AREAS[kinds.index(_kind(action)) if len(kinds) <= len(svg.AREAS) else 0]
        parted = {"stroke": svg.PAPER} if size >= PARTED_PX else {}
        told = f"{words}: cost {number(_short(spent))} to {number(_short(spent + cost))}"
        parts.append(svg.rectangle(x, y, max(size, 1), height, title=told, fill=colour, **parted))
        if across:
            parts.append(svg.text(center, middle, words, text_anchor="middle"))
        elif size >= NARROWEST_PX:
            parts.append(svg.text(center + 4, y + height - 5, svg.shortened(words, height - 8), turned=True))
        spent += cost
    return height, parts if blocks else [*parts, svg.text(left, middle, "nothing to do")]


def _kind(action: str) -> str:
    """Return the first word of an action, which gives it its colour."""
    return action.partition(" ")[0]


def _blocks(actions: Sequence[str], costs: Sequence[Number]) -> list[tuple[str, str, float]]:
    """Return the text, the action and the cost of each run of equal actions."""
    found = []
    for action, run in groupby(zip(actions, costs, strict=True), key=lambda pair: pair[0]):
        each = [float(cost) for _, cost in run]
        found.append((action if len(each) == 1 else f"{len(each)} x {action}", action, sum(each)))
    return found


def _task_row(task: str, cost: Number | None, *, left: float, right: float, y: float, scale: float) -> list[str]:
    """Return the name of a task, and a bar that ends where it is satisfied."""
    middle = y + LINE_PX / 2
    end = right if cost is None else left + scale * float(cost)
    told = "not satisfied" if cost is None else number(cost)
    parts = [svg.text(4, middle + 4, svg.shortened(task, left - 8))]
    dashes = {"stroke_dasharray": "4 4"} if cost is None else {}
    parts.append(svg.line([(left, middle), (end, middle)], stroke=svg.PATH, stroke_width=4, opacity=0.35, **dashes))
    if cost is not None:
        parts.append(svg.dot(end, middle, 5, fill=svg.PATH))
        return [*parts, svg.text(end + 9, middle + 4, told)]
    return [*parts, svg.text(left + 4, middle - 2, told, fill=svg.SOFT, halo=True)]


def _axis(total: float, name: str, *, left: float, y: float, scale: float) -> list[str]:
    """Return the axis of the cost with its ticks."""
    parts = [svg.line([(left, y), (left + scale * total, y)], stroke=svg.SOFT)]
    step = _step(total)
    for k in range(int(total / step * (1 + 1e-9)) + 1 if total else 1):
        x = left + scale * k * step
        parts.append(svg.line([(x, y), (x, y + 4)], stroke=svg.SOFT))
        parts.append(svg.text(x, y + 17, number(_short(k * step)), text_anchor="middle", fill=svg.SOFT))
    return [*parts, svg.text(4, y + 17, svg.shortened(name, left - 8), fill=svg.SOFT)]


def _step(total: float) -> float:
    """Return a distance of 1, 2 or 5 times a power of ten for about `TICKS` ticks."""
    if not total:
        return 1.0
    power = 10.0 ** math.floor(math.log10(total / TICKS))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power >= total / TICKS)


def _short(value: float) -> float:
    """Return a number without the digits that only come from adding floats."""
    return float(f"{value:.12g}")
