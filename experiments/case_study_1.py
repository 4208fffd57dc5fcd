"""Case Study 1 of the paper: a delivery robot's five tasks, and every best trade-off of cost and desired order.

Prints the front beside the published one and every plan, and draws the paper's Figure 3 anew.
"""

from __future__ import annotations

import sys
from pathlib import Path

from experiments.paper.grids import case_study_1
from experiments.paper.show import do_and_show

OUT = Path("out", "case_study_1")
"""Where the figure goes."""


def main() -> int:
    """Plan, compare, draw, and return the exit status: 1 if the front is not the published one."""
    return do_and_show(case_study_1, OUT)


if __name__ == "__main__":
    sys.exit(main())
