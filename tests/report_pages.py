"""What tests of reports share: a grid scenario, a stand-in for the renderer, and the data of a page."""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import pytest
from scenario_texts import task_tables

from experiments.report import recordings
from sim.rendering.quality import DRAFT, Quality

ERRANDS = """# Two errands, and the nearer one is not the one that is preferred first.
[model]
kind = "grid"
size = [4, 3]
start = [0, 0]
[model.regions]
bank = [3, 0, 3, 0]
post = [0, 2, 0, 2]
[model.obstacles]
wall = [1, 1, 1, 1]
""" + task_tables(pay="F bank", send="F post")


@contextmanager
def pictures_for_tests() -> Iterator[list[Path]]:
    """Render a test picture instead of the robot, which needs no OpenGL; yield the videos' paths."""
    videos: list[Path] = []

    def render(scene: Any, rollout: Any, captions: Any, path: Path, quality: Quality = DRAFT, **options: Any) -> Path:
        assert not captions  # the page says it all
        width, height = quality.size
        source = f"testsrc=s={width}x{height}:r=10:d={rollout.sim_seconds + 1.5}"
        command = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-y", "-f", "lavfi", "-i", source]
        subprocess.run([*command, "-c:v", "libx264", "-pix_fmt", "yuv420p", str(path)], check=True)
        videos.append(path)
        return path

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sim.rendering.video.render_video", render)
        patch.setattr(recordings, "check_rendering", lambda: None)
        yield videos


def page(folder: str | Path) -> str:
    return Path(folder, "index.html").read_text(encoding="utf-8")


def data(folder: str | Path) -> Any:
    """Return the JSON data of a report's page."""
    (found,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page(folder), re.DOTALL)
    return json.loads(found)
