"""The style of figures, and their files."""

import io
import logging
import re
import warnings
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

from experiments.cli.files import write_bytes
from experiments.cli.status import tell
from prefplan.errors import PrefplanError

ENDINGS = {".png": {"Software": None}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
"""Supported file endings, with the metadata to leave out so that equal figures give equal files."""

POINTS_PER_INCH = 72
"""Points in an inch: sizes of letters and lines are in points."""

UNKNOWN_LETTERS = "Glyph .* missing from|Matplotlib currently does not support"
"""Beginnings of Matplotlib's warnings about letters that its font lacks, or that it cannot join."""

SVG = "{http://www.w3.org/2000/svg}"
"""Namespace of the elements of SVG."""

LINK = "{http://www.w3.org/1999/xlink}href"
"""Attribute with the source of an image in SVG."""

ET.register_namespace("", SVG[1:-1])
ET.register_namespace("xlink", LINK[1:-5])

STYLE = Path(__file__).with_name("prefplan.mplstyle")

# If the home folder is read-only, Matplotlib would warn where it keeps its list of fonts.
logging.getLogger("matplotlib").setLevel(logging.ERROR)


def picture_file(text: str) -> Path:
    """Return the path of a picture to write.

    Raises:
        PrefplanError: the ending is not supported, or its folder does not exist.
    """
    path = Path(text)
    if path.suffix.lower() not in ENDINGS:
        known = ", ".join(ENDINGS)
        raise PrefplanError(f"{path}: pictures are written to files that end in {known}, not {path.suffix!r}")
    if not path.parent.is_dir():
        raise PrefplanError(f"{path}: cannot be written, since there is no folder {str(path.parent)!r}")
    return path


@contextmanager
def drawing(*, size: tuple[float, float]) -> Iterator[Figure]:
    """Yield an empty figure of a size, inches; the style of all figures holds until the end of the context.

    Text in an SVG is drawn by the program that shows it, also letters that the font used for measuring lacks.
    """
    with matplotlib.rc_context(fname=STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=UNKNOWN_LETTERS)
        yield Figure(figsize=size)


def write_figure(figure: Figure, path: Path) -> None:
    """Write a figure to a path from `picture_file`.

    Raises:
        PrefplanError: the file cannot be written.
    """
    content = io.BytesIO()
    ending = path.suffix.lower()
    with warnings.catch_warnings(record=True) as told:
        warnings.filterwarnings("always", message=UNKNOWN_LETTERS)
        figure.savefig(content, format=ending[1:], metadata=ENDINGS[ending])
    write_bytes(path, content.getvalue())
    lacking = [one for one in told if re.match(UNKNOWN_LETTERS, str(one.message))]
    for other in (one for one in told if one not in lacking):
        warnings.warn_explicit(other.message, other.category, other.filename, other.lineno)
    if lacking and ending != ".svg":
        tell(f"warning: {path}: its font lacks letters of some names; .svg files are shown with more fonts")


def parsed_svg(figure: Figure) -> ET.Element:
    """Return a figure as SVG for a page; the `gid` of each part becomes its classes."""
    content = io.BytesIO()
    figure.set_facecolor("none")
    figure.savefig(content, format="svg", metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    root = ET.fromstring(content.getvalue())
    for part in root.iter():
        # On a page with several figures ids would not be unique.
        if "id" in part.attrib:
            part.set("class", part.attrib.pop("id"))
    return root


def inline_svg(root: ET.Element, *, kind: str, title: str) -> str:
    """Return a parsed SVG as text for a page, of the class `kind`; the title is for screen readers."""
    width, height = (root.attrib[key].removesuffix("pt") for key in ("width", "height"))
    size = {"width": width, "height": height, "style": f"--natural: {width}px; --aspect: calc({width} / {height})"}
    root.attrib.update(size | {"class": kind, "role": "img", "aria-label": title})
    return ET.tostring(root, encoding="unicode")
