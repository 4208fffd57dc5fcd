"""The program: `prefplan`, or `python -m prefplan`."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path


def main() -> int:
    """Run the program and return its exit status."""
    # Its packages have common names such as `sim`; the working directory may have others with these names.
    sys.path.insert(0, str(Path(__file__).parents[1]))
    # Imported by name, because the planner must not depend on the programs.
    status: int = import_module("experiments.program").main()
    return status


if __name__ == "__main__":
    sys.exit(main())
