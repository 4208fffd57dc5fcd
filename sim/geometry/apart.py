"""Scripts that run in a separate process: if one exhausts memory or crashes a library, no other process ends."""

import subprocess
import sys
from pathlib import Path

from prefplan.limits import check_limits, left


def run_apart(script: Path, *arguments: str | bytes, given: bytes = b"", seconds: float) -> tuple[bytes, bool]:
    """Return what a script prints for some arguments and bytes on stdin, and whether it ended well and in time.

    Raises:
        LimitError: the time of the present limits is up.
    """
    command = sys.executable, "-P", "-X", "utf8", script, *arguments
    within = min(seconds, left()[0])
    try:
        return subprocess.run(command, input=given, capture_output=True, timeout=within, check=True).stdout, True
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired) as error:
        check_limits()
        return error.stdout or b"", False
