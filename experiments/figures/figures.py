"""The style of figures, and their files."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from xml.sax.saxutils import quoteattr

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from experiments.cli.files import write_bytes
from prefplan.errors import PrefplanError

ENDINGS = {".png": {"Software": None}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
"""Supported file endings, with the metadata to leave out so that equal figures give equal files."""

POINTS_PER_INCH = 72
"""Points in an inch: sizes of letters and lines are in points."""

STYLE = Path(__file__).with_name("prefplan.mplstyle")


def picture_file(text: str) -> Path:
    """Return the path of a picture to write.

    Raises:
        PrefplanError: the ending is not supported.
    """
    path = Path(text)
    if path.suffix.lower() not in ENDINGS:
        known = ", ".join(ENDINGS)
        raise PrefplanError(f"{path}: pictures are written to files that end in {known}, not {path.suffix!r}")
    return path


@contextmanager
def drawing(*, size: tuple[float, float], layout: bool = False) -> Iterator[Figure]:
    """Yield an empty figure; the style of all figures holds until the end of the context.

    Args:
        size: width and height, inches.
        layout: whether matplotlib places the axes so that nothing overlaps.
    """
    with matplotlib.rc_context({"figure.constrained_layout.use": layout}, STYLE):
        figure = Figure(figsize=size)
        FigureCanvasAgg(figure)
        yield figure


def write_figure(figure: Figure, path: Path) -> None:
    """Write a figure to a path from `picture_file`.

    Raises:
        PrefplanError: the file cannot be written.
    """
    content = io.BytesIO()
    ending = path.suffix.lower()
    figure.savefig(content, format=ending[1:], metadata=ENDINGS[ending])
    write_bytes(path, content.getvalue())


def inline_svg(figure: Figure, *, kind: str, title: str) -> str:
    """Return a figure as inline SVG of the class `kind`; the `gid` of each part becomes its classes."""
    content = io.StringIO()
    figure.set_facecolor("none")
    figure.savefig(content, format="svg", metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    # On a page with several figures ids would not be unique.
    drawn = re.sub(r' id="([^"]*)"', r' class="\1"', content.getvalue())
    drawn = re.sub(r'="([\d.]+)pt"', r'="\1"', drawn[drawn.index("<svg") :], count=2)
    return drawn.replace("<svg ", f'<svg class="{kind}" role="img" aria-label={quoteattr(title)} ', 1)
