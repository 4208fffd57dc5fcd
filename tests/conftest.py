"""What every test may count on."""

from __future__ import annotations

import signal


def pytest_configure() -> None:
    # Whoever starts the tests in the background may have Ctrl-C ignored, and so would the programs they interrupt.
    signal.signal(signal.SIGINT, signal.default_int_handler)
