"""Settings for the quality of a video: resolution, sampling, shadows and encoding."""

from dataclasses import dataclass
from typing import TypedDict


@dataclass(frozen=True)
class Quality:
    """Quality settings of a picture or video.

    Attributes:
        size: (width, height) in pixels, both even.
        samples: number of renderings to average, with different subpixel offsets and points of the key light, for
            smooth edges and soft shadows. With only one, edges are smoothed afterwards.
        shadow_pixels: side of the shadow map.
        rate: constant rate factor of x264: lower is better, and 18 is considered visually lossless.
        preset: of x264.
        lamp_radius_rad: angular radius of the key light. With a larger one, the shadows of its few sample points
            would be distinguishable.
    """

    size: tuple[int, int]
    samples: int
    shadow_pixels: int
    rate: int
    preset: str
    lamp_radius_rad: float = 0.02


# 60 ms on one core per picture; a minute and a half on two cores for both videos of Case Study 3.
DRAFT = Quality((1280, 720), samples=1, shadow_pixels=1024, rate=20, preset="veryfast")
# Nearly ten times the work.
FINAL = Quality((1920, 1080), samples=5, shadow_pixels=2048, rate=17, preset="medium")
QUALITIES = {"draft": DRAFT, "final": FINAL}


class Look(TypedDict, total=False):
    """Options of `sim.rendering.video.render_video`."""

    quality: Quality
    camera: str
