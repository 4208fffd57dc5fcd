"""A plan as a timeline along the cost spent: its actions, and when each task is satisfied."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from html import escape
from itertools import accumulate, cycle, groupby

from prefplan.drawing import svg
from prefplan.exact_costs import Number, exact, to_number
from prefplan.text.layout import number

NAME_PX, WIDTH_PX, COST_PX = 130.0, 560.0, 70.0
"""Widths of the tasks' names, of the row of actions, and of the cost behind the last task."""

TITLE_PX, BLOCK_PX, LINE_PX = 28.0, 150.0, 22.0
"""Heights of the title, of the row of actions, and of a task's row."""

NARROWEST_PX = 13.0
"""Least width of a block that text fits into."""


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
    totals = list(accumulate(map(exact, action_costs), initial=Fraction(0)))
    scale = WIDTH_PX / float(totals[-1] or 1)
    parts = [*_blocks(actions, totals, scale=scale, cost=cost)] or [svg.text(NAME_PX, TITLE_PX + 20, "nothing to do")]
    y = TITLE_PX + BLOCK_PX + LINE_PX / 2
    for name, end in task_costs.items():
        parts += _task(name, end, y=y, right=NAME_PX + scale * float(totals[-1] if end is None else end))
        y += LINE_PX
    return svg.picture(NAME_PX + WIDTH_PX + COST_PX, y, title, parts)


def _blocks(actions: Sequence[str], totals: Sequence[Fraction], *, scale: float, cost: str) -> Iterator[str]:
    """Yield a block for each run of equal actions, as wide as its cost, and text that runs upwards if it fits."""
    kinds = [action.partition(" ")[0] for action in actions]
    colours = dict(zip(dict.fromkeys(kinds), cycle(svg.AREAS), strict=False))
    last = 0
    for action, run in groupby(actions):
        first, last = last, last + len(list(run))
        words = action if last == first + 1 else f"{last - first} x {action}"
        begin, end = (number(to_number(totals[k])) for k in (first, last))
        x, width = NAME_PX + scale * float(totals[first]), scale * float(totals[last] - totals[first])
        box = {"x": x, "y": TITLE_PX, "width": max(width, 1.0), "height": BLOCK_PX}
        look = {"fill": colours[kinds[first]], "stroke": svg.PAPER, "stroke_width": 0.5}
        yield svg.element("rect", svg.element("title", escape(f"{words}: {cost} {begin} to {end}")), **box, **look)
        if width >= NARROWEST_PX:
            foot = x + width / 2 + 4, TITLE_PX + BLOCK_PX - 5
            turned = f"rotate(-90 {foot[0]:.2f} {foot[1]})"
            yield svg.text(*foot, svg.shortened(words, BLOCK_PX - 8), transform=turned, stroke="none")


def _task(name: str, end: Number | None, *, y: float, right: float) -> Iterator[str]:
    """Yield the name of a task, and a line that ends where the task is satisfied, with the cost."""
    yield svg.text(4, y + 4, svg.shortened(name, NAME_PX - 8))
    line = svg.points([(NAME_PX, y), (right, y)])
    dashes = {} if end is not None else {"stroke_dasharray": "4 4"}
    yield svg.element("polyline", points=line, stroke=svg.PATH, stroke_width=4, opacity=0.35, **dashes)
    if end is None:
        yield svg.text(NAME_PX + 4, y - 2, "not satisfied", fill=svg.SOFT)
    else:
        yield svg.element("circle", cx=right, cy=y, r=5, fill=svg.PATH)
        yield svg.text(right + 9, y + 4, number(end))
