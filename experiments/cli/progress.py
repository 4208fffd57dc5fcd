"""Progress bars on a terminal."""

import sys
from collections.abc import Callable

from rich.progress import BarColumn, Progress, Task, TaskID, TimeElapsedColumn, TimeRemainingColumn
from rich.text import Text

from experiments.cli.console import Console
from experiments.cli.status import is_quiet

Tell = Callable[[str, int, int, str], None]
"""Reports progress: the stage, how many of its parts are done, of how many (0: unknown), and the next part."""


class _TimeLeft(TimeRemainingColumn):
    """The time left of a stage under way, where it can be estimated."""

    def render(self, task: Task) -> Text:
        """Return the time in words."""
        if task.finished or task.time_remaining is None:
            return Text("")
        return super().render(task).append(" left")


class Bars(Progress):
    """One bar for each stage of a long command, shown on stderr until the command ends, if that is a terminal."""

    def __init__(self) -> None:
        """Begin without bars; with `-q`, none is ever drawn."""
        console = Console(stderr=True)
        super().__init__(
            "{task.description:>12}",
            BarColumn(),
            "{task.fields[count]}",
            TimeElapsedColumn(),
            _TimeLeft(),
            "{task.fields[what]}",
            console=console,
            transient=True,
            # Text for stdout is redirected only if it shares a terminal with the bars.
            redirect_stdout=sys.stdout.isatty(),
            disable=is_quiet() or not console.is_terminal,
        )
        self._stages: dict[str, TaskID] = {}

    def __call__(self, stage: str, done: int, total: int, what: str) -> None:
        """Show progress, see `Tell`."""
        if stage not in self._stages:
            self._stages[stage] = self.add_task(stage, count="", what="")
        count = f"{done} of {total}" if total else ""
        self.update(self._stages[stage], completed=done, total=total or None, count=count, what=what)
