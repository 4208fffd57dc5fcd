"""The program as a module: `python -m prefplan` does what `prefplan` does."""

import os
import sys


def main() -> None:
    """Replace this process by the program."""
    # With -P, Python does not look for packages with common names, such as `sim`, in the working directory. The program
    # is named as text, because the planner must not depend on it.
    os.execv(sys.executable, [sys.executable, "-P", "-m", "experiments.program", *sys.argv[1:]])


if __name__ == "__main__":
    main()
