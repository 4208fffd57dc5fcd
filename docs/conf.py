"""How Sphinx builds this documentation: `make docs`."""

import sys
from importlib import metadata
from pathlib import Path

sys.path.append(str(Path(__file__).parent / "pictures"))

project = "prefplan"
author = "the prefplan authors"
release = metadata.version("prefplan")

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode", "gallery"]
myst_heading_anchors = 3

default_role = "code"  # docstrings put names between single backquotes
napoleon_use_ivar = True  # fields are described once, by their class
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 90

html_theme = "furo"
html_title = "prefplan"
pygments_style = "friendly"
pygments_dark_style = "monokai"
