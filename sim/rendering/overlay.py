"""Captions over the picture: the current action, the cost up to now, and the status of every task."""

from __future__ import annotations

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
SCRIM = (9, 11, 15)
"""Colour that the lower edge of the picture fades to, behind the text."""

SCRIM_STRENGTH = 0.86
"""Opacity of that colour at the lower edge, 0 .. 1."""

OVERSAMPLING = 2
"""Captions are drawn so many times as large and then reduced, for smooth curves."""


@dataclass(frozen=True)
class TaskStatus:
    """The status of a task.

    Attributes:
        name: the task's name.
        text: its formula, or what it means.
        state: `satisfied` or still `open`.
    """

    name: str
    text: str
    state: Literal["open", "satisfied"]


@dataclass(frozen=True)
class Caption:
    """What is shown over a stretch of the video.

    Attributes:
        start: simulated time from which it is shown, until the next caption's, s.
        end: simulated time at which its action ends, s.
        action: the running action.
        cost: spent so far.
        total: cost of the whole plan.
        tasks: every task, in the order to show.
        preference: mu as far as it is settled; None to leave it out.
        preference_total: mu of the whole plan.
    """

    start: float
    end: float
    action: str
    cost: float
    total: float
    tasks: tuple[TaskStatus, ...]
    preference: float | None = None
    preference_total: float = 0.0


def caption_at(captions: Sequence[Caption], time: float) -> Caption | None:
    """Return the caption to show at a time: the last to have started, if any. They are in order of `start`."""
    index = bisect.bisect_right(captions, time, key=lambda caption: caption.start)
    return captions[index - 1] if index else None


def draw_caption(frame: np.ndarray, caption: Caption) -> None:
    """Draw a caption onto the lower third of a frame, in place.

    Args:
        frame: (height, width, 3) uint8.
        caption: what to draw.
    """
    panel = _panel(caption, frame.shape[1], frame.shape[0])
    band = Image.fromarray(frame[-panel.height :])
    band.paste(panel, mask=panel)
    frame[-panel.height :] = band


@functools.lru_cache(maxsize=4)
def _panel(caption: Caption, width: int, height: int) -> Image.Image:
    """Return the translucent picture to paste over the lower rows of a (height, width) frame."""
    unit = height / 720
    rows = int(unit * max(150, 74 + 27 * len(caption.tasks)))
    canvas = Image.new("RGBA", (width * OVERSAMPLING, rows * OVERSAMPLING), (0, 0, 0, 0))
    _draw(ImageDraw.Draw(canvas), caption, canvas.width, canvas.height, unit * OVERSAMPLING)
    scrim = Image.new("RGBA", (width, rows), SCRIM)
    fade = Image.linear_gradient("L").point([SCRIM_STRENGTH * x * x * (3 - 2 * x / 255) / 255 for x in range(256)])
    scrim.putalpha(fade.resize((width, rows)))
    return Image.alpha_composite(scrim, canvas.resize((width, rows), Image.Resampling.BOX))


def _draw(draw: ImageDraw.ImageDraw, caption: Caption, width: int, height: int, unit: float) -> None:
    """Draw text and marks; `unit` is the length of a pixel of a picture 720 high."""
    left, base = 44 * unit, height - 34 * unit
    draw.text((left, base - 52 * unit), caption.action, fill=INK, font=_font(31 * unit), anchor="ls")
    draw.text((left, base - 20 * unit), _spent(caption), fill=MUTED, font=_font(18 * unit), anchor="ls")
    length = 330 * unit
    share = min(1.0, caption.cost / caption.total) if caption.total else 1.0
    track = (left, base - 4 * unit, left + length, base)
    draw.rounded_rectangle(track, radius=2 * unit, fill=(255, 255, 255, 60))
    if share > 0:
        draw.rounded_rectangle((*track[:2], left + share * length, base), radius=2 * unit, fill=ACCENT)
    column = max(0.40 * width, left + length + 60 * unit)
    for i, task in enumerate(reversed(caption.tasks)):
        _draw_task(draw, task, column, base - 27 * i * unit, width - 44 * unit, unit)


def _spent(caption: Caption) -> str:
    """Return how far cost and preference have risen."""
    cost = f"cost {caption.cost:g} of {caption.total:g}"
    if caption.preference is None:
        return cost
    return f"{cost}     preference {caption.preference:g} of {caption.preference_total:g}"


def _draw_task(
    draw: ImageDraw.ImageDraw, task: TaskStatus, left: float, base: float, right: float, unit: float
) -> None:
    middle, radius = base - 6 * unit, 7.5 * unit
    circle = (left, middle - radius, left + 2 * radius, middle + radius)
    if task.state == "satisfied":
        draw.ellipse(circle, fill=DONE)
        tick = [(0.5, 1.02), (0.88, 1.4), (1.55, 0.66)]
        points = [(left + x * radius, middle - radius + y * radius) for x, y in tick]
        draw.line(points, fill=SCRIM, width=round(2.2 * unit), joint="curve")
    else:
        draw.ellipse(circle, outline=MUTED, width=round(1.6 * unit))
    name = _font(18 * unit)
    start = left + 2 * radius + 11 * unit
    draw.text((start, base), task.name, fill=DONE if task.state == "satisfied" else INK, font=name, anchor="ls")
    start += name.getlength(task.name) + 14 * unit
    small = _font(15.5 * unit)
    draw.text((start, base), _fitting(task.text, small, right - start), fill=MUTED, font=small, anchor="ls")


def _fitting(text: str, font: ImageFont.FreeTypeFont, width: float) -> str:
    """Return the text, shortened with an ellipsis where it is too long."""
    if font.getlength(text) <= width:
        return text
    while text and font.getlength(text + "...") > width:
        text = text[:-1]
    return text.rstrip() + "..."


@functools.lru_cache(maxsize=16)
def _font(size: float) -> ImageFont.FreeTypeFont:
    font = ImageFont.load_default(size=size)
    assert isinstance(font, ImageFont.FreeTypeFont)
    return font
