"""Web pages: filled in from templates, and opened in the browser."""

import os
import webbrowser
from functools import cache

import jinja2

from prefplan.text.layout import number


def open_page(address: str) -> None:
    """Open an address in the browser, if there is a display; without one Python would start a text browser."""
    if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        webbrowser.open(address)


@cache
def template(package: str | None, name: str) -> jinja2.Template:
    """Return a template from a package's folder, with a filter `number` that formats costs."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader(str(package), ""),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["number"] = number
    return environment.get_template(name)
