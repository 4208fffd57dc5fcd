"""Videos composed of finished ones."""

from __future__ import annotations

from pathlib import Path

import imageio_ffmpeg
import mediapy
import numpy as np
import pytest

from sim.rendering.clips import GAP_PX, compose


def video(path: Path, shades: list[int]) -> Path:
    """Write a video of grey pictures, ten a second."""
    mediapy.set_ffmpeg(imageio_ffmpeg.get_ffmpeg_exe())
    mediapy.write_video(path, [np.full((90, 160, 3), shade, dtype=np.uint8) for shade in shades], fps=10, qp=10)
    return path


def pictures(path: Path) -> np.ndarray:
    reader = imageio_ffmpeg.read_frames(str(path))
    width, height = next(reader)["size"]  # type: ignore[index]
    return np.array([np.frombuffer(frame, dtype=np.uint8).reshape(height, width, 3) for frame in reader])  # type: ignore[arg-type]


def test_videos_stand_side_by_side_below_headings_and_the_shorter_rests_on_its_last_picture(tmp_path: Path) -> None:
    videos = [
        video(tmp_path / "long.mp4", [40] * 10 + [80] * 10),
        video(tmp_path / "short.mp4", [200] * 5 + [160] * 5),
    ]
    bare = pictures(compose(videos, tmp_path / "bare.mp4", height=90, fps=10))
    assert bare.shape == (20, 90, 320 + GAP_PX, 3)
    left, right = bare[:, 45, 80, 0].astype(int), bare[:, 45, 244, 0].astype(int)
    assert left == pytest.approx(np.repeat([40, 80], 10), abs=5)
    assert right == pytest.approx([200] * 5 + [160] * 15, abs=5)
    named = pictures(compose(videos, tmp_path / "named.mp4", height=90, fps=10, headings=["first", "second"]))
    strip, below = named[:, :-90], named[:, -90:]
    assert strip.shape[1] > 0 and (abs(bare.astype(int) - below) < 20).mean() > 0.99
    assert strip[..., :160, :].max() > 150 and strip[..., 164:, :].max() > 150
