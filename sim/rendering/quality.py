"""How much work a video's pictures are worth."""

from __future__ import annotations

from dataclasses import dataclass

from assets import VIDEO


@dataclass(frozen=True)
class Quality:
    """What a picture is made of.

    Attributes:
        size: (width, height) in pixels, both even.
        samples: a picture is the mean of so many, each through another point of every pixel and in the light of
            another point of the key light: edges are smooth then, and shadows soft. With one, edges are smoothed
            afterwards.
        shadow_pixels: side of the shadow map.
        rate: constant rate factor of x264: lower is better, 18 is said to look lossless.
        preset: of x264.
    """

    size: tuple[int, int]
    samples: int
    shadow_pixels: int
    rate: int
    preset: str


QUALITIES = {name: Quality(**{**values, "size": tuple(values["size"])}) for name, values in VIDEO["qualities"].items()}
DRAFT, FINAL = QUALITIES["draft"], QUALITIES["final"]
