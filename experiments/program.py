"""Entry point of the program `prefplan`."""

import io
import sys

from experiments.cli.start import handle_ctrl_c, missing, open_streams
from experiments.cli.status import INTERRUPTED, tell


def main() -> int:
    """Load the command line, run it and return its exit status."""
    open_streams()
    handle_ctrl_c()
    try:
        from experiments.commands.command_line import main as run
    except ModuleNotFoundError as error:
        return missing(error)
    except KeyboardInterrupt:
        tell("interrupted")
        return INTERRUPTED
    if isinstance(sys.stdout, io.TextIOWrapper):  # its encoding may lack characters of the user's names
        sys.stdout.reconfigure(errors="backslashreplace")
    return run()


if __name__ == "__main__":
    sys.exit(main())
