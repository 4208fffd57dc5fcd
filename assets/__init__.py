"""MJCF, materials, and the choices that a video offers."""

import tomllib
from pathlib import Path
from typing import Any

VIDEO: dict[str, Any] = tomllib.loads(Path(__file__).with_name("video.toml").read_text(encoding="utf-8"))
"""What `video.toml` says."""
