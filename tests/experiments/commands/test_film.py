"""`prefplan film`: finished videos made shorter and smaller."""

from __future__ import annotations

from pathlib import Path

import imageio_ffmpeg
import mediapy
import numpy as np
import pytest
from command_line import Run, assert_is_error
from PIL import Image, ImageSequence


@pytest.mark.parametrize("ending", ["gif", "webp"])
def test_a_short_video_for_a_page_is_quick_and_small(run: Run, tmp_path: Path, ending: str) -> None:
    mediapy.set_ffmpeg(imageio_ffmpeg.get_ffmpeg_exe())
    shades = [40] * 40 + [80] * 40
    whole, path = tmp_path / "whole.mp4", tmp_path / f"clip.{ending}"
    mediapy.write_video(whole, [np.full((90, 160, 3), shade, dtype=np.uint8) for shade in shades], fps=10, qp=10)
    assert run("film", str(whole), str(path)).status == 0
    frames = [frame.convert("RGB") for frame in ImageSequence.Iterator(Image.open(path))]
    assert frames[0].size == (480, 270) and len(frames) <= 15 * 2 + 1
    shown = [np.asarray(frame)[120, 240, 0] for frame in frames]
    assert abs(int(shown[0]) - 40) < 8 and abs(int(shown[-1]) - 80) < 8
    assert path.stat().st_size < whole.stat().st_size * 20
    assert run("film", str(whole), str(path), "--force").status == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["no.mp4", "clip.gif"], "no.mp4: no such file"),
        (["text.mp4", "clip.gif"], "text.mp4: cannot be read as a video"),
        (["text.mp4", "clip.avi"], ".mp4, .gif, .webp"),
        (["text.mp4", "./text.mp4", "--force"], "text.mp4: is one of the videos to read"),
        (["no.mp4", "text.MP4"], "text.mp4: already exists; --force replaces it"),
    ],
)
def test_what_is_no_video_is_said_in_a_sentence(arguments: list[str], message: str, run: Run, tmp_path: Path) -> None:
    Path("text.mp4").write_text("no video")
    result = run("film", *arguments)
    assert_is_error(result, message)
    assert len(result.err.splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["text.mp4"]
