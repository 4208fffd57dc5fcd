"""Captions in a strip below the picture: the current action, the cost so far, and the status of every task."""

import bisect
import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from PIL import Image, ImageDraw, ImageFont

INK = (245, 246, 248)
MUTED = (168, 174, 184)
ACCENT = (255, 190, 92)
DONE = (96, 206, 138)
GROUND = (9, 11, 15)
TRACK = (52, 56, 63)

STRIP = 0.15
"""Height of the strip, as a share of the frame's."""

TASKS_LEFT = 0.42
"""Left edge of the tasks, as a share of the frame's width."""

ROWS = 3
"""Greatest number of tasks in one column; with more, there are two columns, in a smaller font if need be."""

LEAST_LETTERS_PX = 15
"""Least font size of tasks, below which their texts are cut instead, pixels of a frame 720 high."""

MARGIN_PX = 36
"""Free space to the left and right of the text, pixels of a frame 720 high."""

MARK = 0.42
"""Radius of the mark before a task, in sizes of its font."""

OVERSAMPLING = 2
"""Supersampling factor of captions, for smooth curves."""


@dataclass(frozen=True)
class TaskStatus:
    """The status of a task, and its formula in words."""

    name: str
    text: str
    state: Literal["open", "satisfied"]


@dataclass(frozen=True)
class Caption:
    """The text below the picture during an interval of the video.

    Attributes:
        start: simulated time from which it is shown, until the next caption starts, s.
        action: the running action.
        cost: spent so far.
        total: cost of the whole plan.
        tasks: every task, in the order to show.
        preference: penalty mu so far; None to leave it out.
        preference_total: mu of the whole plan.
    """

    start: float
    action: str
    cost: float
    total: float
    tasks: tuple[TaskStatus, ...]
    preference: float | None = None
    preference_total: float = 0.0


def caption_at(captions: Sequence[Caption], time: float) -> Caption | None:
    """Return the caption to show at a time, s, from captions in order of `start`: the last that has started, if any."""
    index = bisect.bisect_right(captions, time, key=lambda caption: caption.start)
    return captions[index - 1] if index else None


def strip_height(height: int) -> int:
    """Return the (even) height of the strip for an even height of the frame, pixels."""
    return 2 * round(STRIP * height / 2)


def with_strip(picture: np.ndarray, caption: Caption | None, height: int) -> np.ndarray:
    """Return a (height, width, 3) uint8 frame: a caption, or an empty strip, below a picture that fills the rest."""
    return np.concatenate([picture, _strip(caption, picture.shape[1], height)])


@functools.lru_cache(maxsize=4)
def _strip(caption: Caption | None, width: int, height: int) -> np.ndarray:
    rows = strip_height(height)
    canvas = Image.new("RGB", (width * OVERSAMPLING, rows * OVERSAMPLING), GROUND)
    if caption:
        draw, unit = ImageDraw.Draw(canvas), height / 720 * OVERSAMPLING
        _draw_progress(draw, caption, canvas.width, unit)
        _draw_tasks(draw, caption.tasks, canvas.width, unit)
    return np.asarray(canvas.resize((width, rows), Image.Resampling.BOX))


def _draw_progress(draw: ImageDraw.ImageDraw, caption: Caption, width: int, unit: float) -> None:
    """Draw the action and the costs so far; `unit` is the length of a pixel of a frame 720 high."""
    share = min(1.0, caption.cost / caption.total) if caption.total else 1.0
    draw.rectangle((0, 0, width, 3 * unit), fill=TRACK)
    draw.rectangle((0, 0, share * width, 3 * unit), fill=ACCENT)
    left, right = MARGIN_PX * unit, TASKS_LEFT * width - 20 * unit
    large, small = _font(28 * unit), _font(18 * unit)
    draw.text((left, 40 * unit), _fitting(caption.action, large, right - left), fill=INK, font=large, anchor="ls")
    draw.text(
        (left, 69 * unit), f"cost so far {caption.cost:g} of {caption.total:g}", fill=MUTED, font=small, anchor="ls"
    )
    if caption.preference is not None:
        spent = f"penalty so far {caption.preference:g} of {caption.preference_total:g}"
        draw.text((left, 94 * unit), spent, fill=MUTED, font=small, anchor="ls")


def _draw_tasks(draw: ImageDraw.ImageDraw, tasks: Sequence[TaskStatus], width: int, unit: float) -> None:
    """Draw the tasks in one column or two, downwards."""
    columns = 1 if len(tasks) <= ROWS else 2
    rows = max(ROWS, -(-len(tasks) // columns))
    pitch = 93 * unit / rows
    right = width - MARGIN_PX * unit
    across = (right - TASKS_LEFT * width) / columns
    space, letters = across - 12 * unit, 0.6 * pitch
    longest = max((_task_width(task, letters) for task in tasks), default=space)
    # 2 % smaller than the exact fit, since widths of letters are rounded.
    letters = min(letters, max(LEAST_LETTERS_PX * unit, 0.98 * letters * space / longest))
    for i, task in enumerate(tasks):
        column, row = divmod(i, rows)
        left = TASKS_LEFT * width + column * across
        _draw_task(draw, task, left, 9 * unit + (row + 0.5) * pitch, left + space, letters)


def _task_width(task: TaskStatus, letters: float) -> float:
    """Return the width of what `_draw_task` draws."""
    return _font(letters).getlength(task.name + task.text) + (2 * MARK + 1.4) * letters


def _draw_task(
    draw: ImageDraw.ImageDraw, task: TaskStatus, left: float, middle: float, right: float, letters: float
) -> None:
    """Draw the mark, the name and the text of a task in one line, vertically centred at `middle`."""
    radius = MARK * letters
    circle = (left, middle - radius, left + 2 * radius, middle + radius)
    if task.state == "satisfied":
        draw.ellipse(circle, fill=DONE)
        tick = [(0.5, 1.02), (0.88, 1.4), (1.55, 0.66)]
        points = [(left + x * radius, middle - radius + y * radius) for x, y in tick]
        draw.line(points, fill=GROUND, width=round(0.12 * letters), joint="curve")
    else:
        draw.ellipse(circle, outline=MUTED, width=round(0.09 * letters))
    font = _font(letters)
    start = left + 2 * radius + 0.6 * letters
    draw.text((start, middle), task.name, fill=DONE if task.state == "satisfied" else INK, font=font, anchor="lm")
    start += font.getlength(task.name) + 0.8 * letters
    draw.text((start, middle), _fitting(task.text, font, right - start), fill=MUTED, font=font, anchor="lm")


def _fitting(text: str, font: ImageFont.FreeTypeFont, width: float) -> str:
    """Return the text, shortened with an ellipsis if it is wider than `width`."""
    if font.getlength(text) <= width:
        return text
    kept = bisect.bisect_right(range(len(text)), width, lo=1, key=lambda end: font.getlength(f"{text[:end]}...")) - 1
    return text[:kept].rstrip() + "..."


@functools.lru_cache(maxsize=16)
def _font(size: float) -> ImageFont.FreeTypeFont:
    font = ImageFont.load_default(size=size)
    assert isinstance(font, ImageFont.FreeTypeFont)
    return font
