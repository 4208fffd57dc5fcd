"""Make the README's pictures of Case Study 3: a frame of the cheapest and the preferred plan, and a video of both."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from experiments.runs.captions import captions
from experiments.runs.outcome import Outcome
from experiments.runs.run_plan import run_plan, scene_of
from prefplan import Scenario, pareto_front
from prefplan.scenario.decode import load
from sim.rendering.clips import compose
from sim.rendering.overlay import caption_at
from sim.rendering.quality import DRAFT, FINAL
from sim.rendering.video import render_frame, render_video
from sim.simulation.run import FRAME_RATE_HZ
from sim.world.scene import Scene

OUT = Path(__file__).parents[1]

SHOWN = (880, 495)
"""Size of a stored frame, (width, height) in pixels."""

QUALITY = 84
"""Quality of the JPEG files: about 50 kB each."""

BEFORE = FRAME_RATE_HZ // 2
"""Frames between the stored one and the last one of the sanitizer's light."""

VIDEO_SIZE = (640, 360)
"""Size of each of the two videos, (width, height) in pixels."""

FPS, SPEED = 4, 4
"""Frames per second of simulated time, and how many times faster they are shown."""


def main() -> None:
    """Carry out both plans; keep a frame of each while the sanitizer works last, and a video of both."""
    scenario = load("case_study_3")
    scene = scene_of(scenario)
    front = pareto_front(scenario.problem())
    OUT.mkdir(exist_ok=True)
    videos, headings = [], []
    with tempfile.TemporaryDirectory() as folder:
        for name, plan in {"cheapest": front[0], "preferred": front[-1]}.items():
            outcome = run_plan(scenario, scene, plan)
            texts = captions(outcome)
            taken(scenario, scene, outcome).save(OUT / f"{name}.jpg", quality=QUALITY, optimize=True)
            video = Path(folder, f"{name}.mp4")
            videos.append(render_video(scene, outcome.run, texts, video, quality=replace(DRAFT, size=VIDEO_SIZE)))
            headings.append(f"{name}: cost {plan.cost}")
        compose(videos, OUT / "trade_off.webp", headings=headings, height=VIDEO_SIZE[1], fps=FPS * SPEED, speed=SPEED)


def taken(scenario: Scenario, scene: Scene, outcome: Outcome) -> Image.Image:
    """Return a picture of a run just before the light of a location that works last goes out, else from its middle."""
    rollout = outcome.run
    lit = np.flatnonzero(rollout.glow >= 0)
    moment = int(lit[-1]) - BEFORE if len(lit) else len(rollout.times) // 2
    lamps = [scene.model.locations[rollout.glow[moment]].name] if len(lit) else []
    caption = caption_at(captions(outcome), float(rollout.times[moment]))
    frame = render_frame(scene, rollout.qpos[moment], caption=caption, glow=lamps, quality=FINAL)
    return Image.fromarray(frame).resize(SHOWN, Image.Resampling.LANCZOS)


if __name__ == "__main__":
    main()
