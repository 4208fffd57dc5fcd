"""All studies on one self-contained page."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

import jinja2

from experiments.cli.files import write_bytes
from experiments.paper.findings import AGREES, DIFFERS, ERRATUM, MEASURED, Study

CLASSES = {AGREES: "agrees", DIFFERS: "differs", ERRATUM: "errs", MEASURED: "measured"}
"""How verdicts look."""

KINDS = {".svg": "image/svg+xml", ".png": "image/png"}


def write_page(studies: Sequence[Study], path: Path) -> None:
    """Write the page, pictures and all.

    Raises:
        PrefplanError: it cannot be written.
    """
    template = files(__package__).joinpath("summary.html").read_text("utf-8")
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    page = environment.from_string(template).render(
        studies=studies, inlined=_inlined, classes=CLASSES, whole=all(s.reproduced for s in studies)
    )
    write_bytes(path, page.encode())


def _inlined(picture: Path) -> str:
    """Return a picture as an address that holds it."""
    return f"data:{KINDS[picture.suffix]};base64,{base64.b64encode(picture.read_bytes()).decode()}"
