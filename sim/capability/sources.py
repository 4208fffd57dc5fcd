"""The sources that decide what the arm can do and how it moves: answers found with other sources are outdated."""

import hashlib
from pathlib import Path

FOLDERS = ("geometry", "external", "robots", "world", "perception", "motion", "simulation", "skills", "capability")
"""Folders of `sim` with these sources."""


def digest_of_sources() -> str:
    """Return a digest of the sources."""
    digest, sim = hashlib.sha256(), Path(__file__).parents[1]
    programs = (path for name in FOLDERS for path in sorted((sim / name).rglob("*.py")))
    # Which bodies an error names decides what stands in the way of an action.
    for path in (sim / "errors.py", *programs, *sorted((sim.parent / "assets").glob("*.xml"))):
        digest.update(path.read_text(encoding="utf-8").encode())
    return digest.hexdigest()
