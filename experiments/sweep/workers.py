"""Processes that compute the rollouts of a sweep: on this machine, or on a Dask cluster."""

from __future__ import annotations

import signal
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from itertools import takewhile

from joblib import Parallel, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError

from experiments.sweep.job import RolloutRecord, Sweep, failure, roll_out
from prefplan.errors import PrefplanError

CRASHED = "crashed"
"""Class of a rollout whose process ended without a result, twice."""

CLUSTER_TIMEOUT_S = 30
"""How long to wait for a cluster's scheduler, and then for its first worker."""

IDLE_TIMEOUT_S = 20
"""A process on this machine ends after this time without work, even if its parent was killed."""


def on_this_machine(
    sweep: Sweep, numbers: Iterable[int], *, jobs: int, enough: Callable[[], bool] = lambda: False
) -> Generator[RolloutRecord, None, None]:
    """Yield the record of every rollout, in the order in which they finish.

    When a process is killed, the unfinished rollouts are tried again one at a time, to find the one that kills its
    process, which is recorded as crashed. No rollout is begun after `enough` returns True.
    """
    # joblib warns when it replaces a process that has grown, and when pending rollouts are cancelled.
    warnings.filterwarnings("ignore", category=UserWarning, module="joblib")
    waiting = list(numbers)
    while waiting and not enough():
        try:
            for record in _in_processes(sweep, takewhile(lambda _: not enough(), tuple(waiting)), jobs):
                waiting.remove(record["rollout"])
                yield record
        except TerminatedWorkerError:
            # Rollouts are handed out in order, and never more than `jobs` at a time.
            for number in waiting[:jobs]:
                waiting.remove(number)
                yield _alone(sweep, number)


def _alone(sweep: Sweep, number: int) -> RolloutRecord:
    # It may have been another rollout that killed the process: only crashes of this one alone count.
    for _ in range(2):
        with suppress(TerminatedWorkerError):
            (record,) = _in_processes(sweep, [number], 1)
            return record
    return failure(sweep, number, CRASHED, "the process that carried it out ended without a result, twice")


def _in_processes(sweep: Sweep, numbers: Iterable[int], jobs: int) -> Iterator[RolloutRecord]:
    # With n_jobs=1 joblib would use this process, which must survive a crash: so there are at least two processes,
    # but at most `jobs` rollouts at a time.
    with parallel_config(backend="loky", inner_max_num_threads=1, idle_worker_timeout=IDLE_TIMEOUT_S), _no_ctrl_c():
        pool = Parallel(n_jobs=max(2, jobs), pre_dispatch=jobs, batch_size=1, return_as="generator_unordered")
        results = pool(delayed(_ignore_ctrl_c)(roll_out, sweep, number) for number in numbers)
    yield from results


def _ignore_ctrl_c(function: Callable[[Sweep, int], RolloutRecord], sweep: Sweep, number: int) -> RolloutRecord:
    """Call a function with Ctrl-C ignored, which the parent handles; libraries may have unblocked the signal."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    return function(sweep, number)


@contextmanager
def _no_ctrl_c() -> Iterator[None]:
    """Block Ctrl-C in processes that are started in this context: this process shuts them down."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def on_cluster(sweep: Sweep, numbers: Iterable[int], *, address: str) -> Generator[RolloutRecord, None, None]:
    """Yield the record of every rollout, in the order in which the workers of a running Dask cluster finish them.

    If a worker is lost, the scheduler gives its rollout to another one, up to `allowed-failures` times. (joblib's own
    Dask backend waits forever for such a rollout.)

    Raises:
        PrefplanError: Dask is not installed, no cluster with a worker answers, or its scheduler was lost.
    """
    try:
        from distributed import Client, as_completed
        from distributed.scheduler import KilledWorker
    except ImportError:
        raise PrefplanError(
            "--cluster: Dask is not installed; install it: pip install '.[cluster]', in a clone of prefplan"
        ) from None
    try:
        client = Client(address, timeout=CLUSTER_TIMEOUT_S)
        client.wait_for_workers(1, timeout=CLUSTER_TIMEOUT_S)
    except TimeoutError as error:
        raise PrefplanError(f"--cluster {address}: no scheduler with a worker answers ({error})") from None
    except (OSError, ValueError) as error:
        raise PrefplanError(f"--cluster {address}: no Dask scheduler answers ({error})") from None
    with client:
        futures = {client.submit(partial(roll_out, sweep), number, pure=False): number for number in numbers}
        for future in as_completed(futures):
            if future.status == "finished":
                yield future.result()
            elif future.status == "error" and isinstance(future.exception(), KilledWorker):
                yield failure(sweep, futures[future], CRASHED, "the workers that carried it out were lost")
            else:
                why = future.exception() if future.status == "error" else "the scheduler was lost"
                raise PrefplanError(f"--cluster {address}: {why}; the same command continues the sweep")
