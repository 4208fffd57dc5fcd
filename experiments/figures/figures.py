"""The style of figures, and their files."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from experiments.cli.files import write_bytes
from prefplan.errors import PrefplanError

ENDINGS = {".png": {"Software": None}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
"""Endings of files that can be written, with the metadata to leave out so that equal figures give equal files."""

STYLE = Path(__file__).with_name("prefplan.mplstyle")


def picture_file(text: str) -> Path:
    """Return the path of a picture to write.

    Raises:
        PrefplanError: the ending is not a known kind of picture.
    """
    path = Path(text)
    if path.suffix.lower() not in ENDINGS:
        known = ", ".join(ENDINGS)
        raise PrefplanError(f"{path}: pictures are written to files that end in {known}, not {path.suffix!r}")
    return path


@contextmanager
def drawing(path: Path, *, size: tuple[float, float]) -> Iterator[Figure]:
    """Give a figure with the style of all figures, and write it at the end of the block.

    Args:
        path: from `picture_file`.
        size: width and height, inches.

    Raises:
        PrefplanError: the file cannot be written.
    """
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=size)
        FigureCanvasAgg(figure)
        yield figure
        content = io.BytesIO()
        ending = path.suffix.lower()
        figure.savefig(content, format=ending[1:], metadata=ENDINGS[ending])
    write_bytes(path, content.getvalue())
