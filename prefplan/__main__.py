"""The program as a module: `python -m prefplan` does what `prefplan` does."""

from __future__ import annotations

import os
import sys


def main() -> None:
    """Replace this process by the program."""
    # Its packages have common names such as `sim`. With -P, Python does not search the working directory, which may have
    # others of these names; the program is named as text, because the planner must not depend on it.
    os.execv(sys.executable, [sys.executable, "-P", "-m", "experiments.program", *sys.argv[1:]])


if __name__ == "__main__":
    main()
