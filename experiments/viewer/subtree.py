"""A part of a page's scene with a place of its own, so that the same scene can be on the page twice."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import viser


class Subtree:
    """Stands for a server to whoever adds to its scene: every node that is added goes below one.

    Attributes:
        scene: itself; a server has its scene there.
        nodes: what was added, by the name that was asked for.
    """

    def __init__(self, server: viser.ViserServer, root: str, offset: np.ndarray) -> None:
        """Add the node above all others.

        Args:
            server: where to.
            root: the node's name, such as `/left`.
            offset: (3,) where the origin of what is added is on the page, m.
        """
        self.scene = self
        self.nodes: dict[str, Any] = {}
        self._server, self._root = server, root
        self._frame = server.scene.add_frame(root, show_axes=False, position=offset)

    def show(self, visible: bool) -> None:
        """Show or hide all of it."""
        self._frame.visible = visible

    def __getattr__(self, name: str) -> Any:
        """Return what the server or its scene has, with new nodes put where they belong."""
        found = getattr(self._server.scene, name, None) or getattr(self._server, name)
        return self._below(found) if name.startswith("add_") else found

    def _below(self, add: Callable[..., Any]) -> Callable[..., Any]:
        def add_below(name: str, *arguments: Any, **options: Any) -> Any:
            self.nodes[name] = add(self._root + name, *arguments, **options)
            return self.nodes[name]

        return add_below
