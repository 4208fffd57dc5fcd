"""Scripts that run in a process of their own: what exhausts or crashes a library ends no other."""

import subprocess
import sys
from pathlib import Path

from prefplan.limits import check_limits, left


def run_apart(script: Path, *arguments: str | bytes, given: bytes = b"", seconds: float) -> bytes | None:
    """Return what a script prints for some arguments and bytes on stdin; None if it fails or takes longer than that.

    Raises:
        LimitError: the time of the present limits is up.
    """
    command = sys.executable, "-P", "-X", "utf8", script, *arguments
    within = min(seconds, left()[0])
    try:
        return subprocess.run(command, input=given, capture_output=True, timeout=within, check=True).stdout
    except subprocess.SubprocessError:
        check_limits()
        return None
