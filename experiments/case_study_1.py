"""Case Study 1 of the paper: a delivery robot's five tasks, and every best trade-off of cost and desired order.

Prints the front beside the published one and every plan, and draws the paper's Figure 3 anew.
"""

from __future__ import annotations

import sys
from pathlib import Path

from experiments.console import Console
from experiments.files import make_folder
from experiments.paper.grids import case_study_1
from experiments.reproduce_paper import DIFFERENT, show
from experiments.status import DONE

OUT = Path("out", "case_study_1")
"""Where the figure goes."""


def main() -> int:
    """Plan, compare, draw, and return the exit status: 1 if the front is not the published one."""
    make_folder(OUT)
    study = case_study_1(OUT)
    console = Console(highlight=False)
    show(console, study)
    for line in study.texts:
        console.print(line, markup=False)
    return DONE if study.reproduced else DIFFERENT


if __name__ == "__main__":
    sys.exit(main())
