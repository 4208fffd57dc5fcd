"""Studies in the terminal."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from experiments.cli.console import Console
from experiments.cli.files import make_folder
from experiments.cli.status import DONE
from experiments.paper.findings import Study, as_table, remarks

DIFFERENT = 1
"""Exit status when something is not as the paper has it."""


def show(console: Console, study: Study) -> None:
    """Print a study, paper and ours side by side."""
    if study.failure is None:
        console.print(as_table(study))
    else:
        console.print(f"{study.title}: {study.failure}", markup=False)
    for line in remarks(study):
        console.print(f"  {line}", markup=False, style="dim")
    for picture, _ in study.figures:
        console.print(f"  {picture}", markup=False)
    console.print()


def do_and_show(work: Callable[[Path], Study], out: Path) -> int:
    """Do one study, with its figures in a folder, print it with its plans, and return the exit status."""
    make_folder(out)
    study = work(out)
    console = Console(highlight=False)
    show(console, study)
    for line in study.texts:
        console.print(line, markup=False)
    return DONE if study.reproduced else DIFFERENT
