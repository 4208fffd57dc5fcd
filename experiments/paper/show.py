"""Studies in the terminal."""

from __future__ import annotations

from experiments.cli.console import Console
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
