"""The program: `prefplan`, or `python -m prefplan`."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path


def main() -> int:
    """Run the program and return its exit status."""
    # It is made of packages with common names, `sim` among them: where it is called there may be others of that name.
    sys.path.insert(0, str(Path(__file__).parents[1]))
    # By name, because the planner knows nothing of programs.
    status: int = import_module("experiments.program").main()
    return status


if __name__ == "__main__":
    sys.exit(main())
