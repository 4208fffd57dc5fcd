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
"""Of files that can be written, with what has to be left out so that the same figure gives the same file."""

STYLE = Path(__file__).with_name("prefplan.mplstyle")


def picture_file(text: str) -> Path:
    """Return the path of a picture to write.

    Raises:
        PrefplanError: its ending does not say which kind of picture.
    """
    path = Path(text)
    if path.suffix.lower() not in ENDINGS:
        known = ", ".join(ENDINGS)
        raise PrefplanError(f"{path}: pictures are written to files that end in {known}, not {path.suffix!r}")
    return path


@contextmanager
def drawing(path: Path, *, size: tuple[float, float]) -> Iterator[Figure]:
    """Give a figure in the house style, and write it when it is drawn.

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
