"""Text output: framed tables and colour on a terminal, plain columns elsewhere; foreign text is escaped everywhere."""

import os
from collections.abc import Collection, Iterable, Sequence
from typing import Any, NoReturn

import rich.console
from rich.segment import Segment
from rich.table import Table

from prefplan.text.layout import printable_lines

UNLIMITED = 10_000
"""Line width without a terminal, so that nothing wraps; the environment's COLUMNS takes precedence."""

NARROWEST = 8
"""Least width of a column with longer cells, letters, even if the table is then wider than the terminal."""

BESIDE = 3
"""Letters of frame and padding for each column of a framed table."""

COLUMN_GAP = (0, 2, 0, 0)
"""Padding of a plain cell: above, right, below, left."""


class Console(rich.console.Console):
    """Standard output that may be a terminal, a file, or a pipe whose reader closes it early."""

    def __init__(self, *, stderr: bool = False) -> None:
        """Write to stdout, or to stderr, where lines wrap; brackets and colons in strings have no special meaning."""
        # With COLUMNS=0, rich would print nothing.
        given = {name: value for name, value in os.environ.items() if name != "COLUMNS" or value.strip("0")}
        super().__init__(
            soft_wrap=not stderr, stderr=stderr, markup=False, emoji=False, highlight=False, _environ=given
        )
        if not self.is_terminal and not given.get("COLUMNS", "").isdigit():
            self.width = UNLIMITED

    def print(self, *objects: Any, **options: Any) -> None:
        """Print like rich, but never truncate tables, and print them as plain columns if there is no terminal."""
        for table in objects:
            if not isinstance(table, Table):
                continue
            for column in table.columns:
                longest = max((len(str(cell)) for cell in column.cells), default=0)
                column.overflow, column.min_width = "fold", longest if column.no_wrap else min(longest, NARROWEST)
            least = 1 + sum(BESIDE + (column.min_width or 0) for column in table.columns)
            if least > self.width:
                table.width = least
            if not self.is_terminal:
                table.box, table.padding, table.pad_edge = None, COLUMN_GAP, False
        super().print(*objects, **options)

    def _render_buffer(self, buffer: Iterable[Segment]) -> str:
        """Return what is written, with all text escaped: rich's own codes are in styles and control segments."""
        return super()._render_buffer(
            segment if segment.control else Segment(printable_lines(segment.text), segment.style) for segment in buffer
        )

    def on_broken_pipe(self) -> NoReturn:
        """Let the program's `main` handle the BrokenPipeError; rich would exit with status 1."""
        raise


def table(
    title: str,
    heads: Sequence[str],
    rows: Iterable[Sequence[str]],
    *,
    right: Collection[int] = (),
    bold: Collection[int] = (),
) -> Table:
    """Return a table of plain text, below a title if there is one.

    `right` are the numbers of the columns that are aligned to the right, and `bold` of those that stand out.
    """
    found = Table(title=title or None, title_justify="left")
    for k, head in enumerate(heads):
        found.add_column(head, justify="right" if k in right else "left", style="bold" if k in bold else None)
    for cells in rows:
        found.add_row(*cells)
    return found
