"""Case Study 2 of the paper: two tasks contradict each other, so that some are relaxed for a price.

Prints the front beside the published one and every plan, and draws the paper's Figure 4 anew.
"""

from __future__ import annotations

import sys
from pathlib import Path

from experiments.paper.grids import case_study_2
from experiments.paper.show import do_and_show

OUT = Path("out", "case_study_2")
"""Where the figure goes."""


def main() -> int:
    """Plan, compare, draw, and return the exit status: 1 if the front is not the published one."""
    return do_and_show(case_study_2, OUT)


if __name__ == "__main__":
    sys.exit(main())
