"""Work in other processes, by joblib. Ctrl-C reaches this process alone."""

import signal
import threading
from collections.abc import Iterable, Iterator
from typing import Any

from joblib import Parallel, parallel_config

IDLE_TIMEOUT_S = 20
"""A process ends after this time without work, even if its parent was killed."""


def in_processes(calls: Iterable[Any], *, jobs: int, batch: int = 1) -> Iterator[Any]:
    """Yield results of calls, made by joblib's `delayed`, as they finish; a process takes `batch` of them at a time.

    Only the main thread may handle signals: if another thread calls this, Ctrl-C reaches the processes, too.

    Raises:
        TerminatedWorkerError: a process was killed.
    """
    handles_signals = threading.current_thread() is threading.main_thread()
    if handles_signals:
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # for the processes, too: this one shuts them down
    try:
        # With n_jobs=1 joblib would use this process, which must survive a crash: so there are at least two processes,
        # but at most `jobs` batches at a time.
        with parallel_config(backend="loky", inner_max_num_threads=1, idle_worker_timeout=IDLE_TIMEOUT_S):
            pool = Parallel(
                n_jobs=max(2, jobs), pre_dispatch=jobs * batch, batch_size=batch, return_as="generator_unordered"
            )
            results = pool(calls)
    finally:
        if handles_signals:
            signal.signal(signal.SIGINT, before)
    yield from results
