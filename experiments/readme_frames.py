"""Make the README's pictures: the same moment of Case Study 3 as the cheapest and the preferred plan come to it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from experiments import scenarios
from experiments.captions import captions
from experiments.carry_out import carry_out, scene_of
from prefplan import pareto_front
from sim.overlay import caption_at
from sim.rollout import FRAME_RATE
from sim.video import render_frame

OUT = Path(__file__).parents[1] / "docs"

SIZE = (1280, 720)
"""Rendered, as in the videos, (width, height) in pixels."""

SHOWN = (880, 495)
"""Stored, (width, height) in pixels."""

QUALITY = 84
"""Of the JPEG files: about 50 kB each."""

BEFORE = FRAME_RATE // 2
"""How many frames before the sanitizer's last one."""


def main() -> None:
    """Carry both plans out and keep, of each, a moment at which the sanitizer does its last work."""
    scenario = scenarios.find("case_study_3")
    scene = scene_of(scenario)
    front = pareto_front(scenario.problem())
    OUT.mkdir(exist_ok=True)
    for name, plan in {"cheapest": front[0], "preferred": front[-1]}.items():
        outcome = carry_out(scenario, scene, plan)
        rollout = outcome.rollout
        moment = int(np.flatnonzero(rollout.glow >= 0)[-1]) - BEFORE
        lamp = scene.model.locations[rollout.glow[moment]].name
        texts = captions(scenario.tasks, rollout, outcome.books, plan=plan)
        caption = caption_at(texts, float(rollout.times[moment]))
        frame = render_frame(scene, rollout.qpos[moment], caption=caption, glow=[lamp], size=SIZE)
        picture = Image.fromarray(frame).resize(SHOWN, Image.Resampling.LANCZOS)
        picture.save(OUT / f"{name}.jpg", quality=QUALITY, optimize=True)


if __name__ == "__main__":
    main()
