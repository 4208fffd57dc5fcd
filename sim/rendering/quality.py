"""How much work a video's pictures are worth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypedDict


@dataclass(frozen=True)
class Quality:
    """What a picture is made of.

    Attributes:
        size: (width, height) in pixels, both even.
        samples: number of pictures of which each is the mean, each through another point of every pixel and in the
            light of another point of the key light: edges are smooth then, and shadows soft. With one, edges are
            smoothed afterwards.
        shadow_pixels: side of the shadow map.
        rate: constant rate factor of x264: lower is better, 18 is said to look lossless.
        preset: of x264.
    """

    size: tuple[int, int]
    samples: int
    shadow_pixels: int
    rate: int
    preset: str


# A draft takes 60 ms of one core a picture, both videos of Case Study 3 a minute and a half on two cores.
DRAFT = Quality((1280, 720), samples=1, shadow_pixels=1024, rate=20, preset="veryfast")
# Nearly ten times the work.
FINAL = Quality((1920, 1080), samples=5, shadow_pixels=2048, rate=17, preset="medium")
QUALITIES = {"draft": DRAFT, "final": FINAL}


class Look(TypedDict, total=False):
    """How a video looks.

    Attributes:
        quality: of its pictures; a draft unless it is said.
        camera: that it is seen from; `fixed` unless it is said.
    """

    quality: Quality
    camera: str
