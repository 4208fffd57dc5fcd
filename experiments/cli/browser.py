"""Pages opened in the browser."""

from __future__ import annotations

import os
import webbrowser


def open_page(address: str) -> None:
    """Open an address in the browser, if there is a display; without one Python would start a browser for text."""
    if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        webbrowser.open(address)
