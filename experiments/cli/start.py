"""Start of the program: Ctrl-C while libraries load, and a message before the search is compiled."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from experiments.cli.status import INTERRUPTED


def tell_if_compiling(*, quiet: bool = False) -> None:
    """Print on stderr that compiling takes a minute, if the search is not compiled and `quiet` is False."""
    from prefplan.warm_up import is_compiled

    if not quiet and not is_compiled():
        print("prefplan: compiling the search, once; this takes 10 to 30 seconds", file=sys.stderr, flush=True)


@contextmanager
def loading() -> Iterator[None]:
    """End the process at once on Ctrl-C: while libraries load, they drop a KeyboardInterrupt or print a traceback."""
    before = signal.signal(signal.SIGINT, _end)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _end(number: int, frame: FrameType | None) -> None:
    print("prefplan: interrupted", file=sys.stderr, flush=True)
    os._exit(INTERRUPTED)
