"""Where the rollouts of a sweep are computed: in processes of this machine, or on a Dask cluster."""

from __future__ import annotations

import signal
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager
from functools import partial

from joblib import Parallel, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError

from experiments.sweep.job import Record, Sweep, failure, roll_out
from prefplan.errors import PrefplanError

CRASHED = "crashed"
"""Class of a rollout whose process ended without an answer, and so did the next one's."""

PATIENCE = 30
"""How long a cluster may take to answer and to have a worker, s."""

IDLE = 20
"""After how long without work a process of this machine ends, s: also one whose parent was killed."""


def on_this_machine(sweep: Sweep, numbers: Iterable[int], *, jobs: int) -> Generator[Record, None, None]:
    """Yield the record of every rollout, as they come.

    When a process is killed, what was under way is tried again, one rollout at a time, so that the guilty one is
    known: it is recorded as crashed.

    Args:
        sweep: what is swept.
        numbers: of the rollouts.
        jobs: how many processes work.
    """
    # A process that has grown is replaced by another, of which nobody needs to hear.
    warnings.filterwarnings("ignore", message="A worker stopped while some jobs were given to the executor")
    waiting = iter(numbers)
    while True:
        under_way: set[int] = set()
        try:
            yield from _in_processes(sweep, waiting, under_way, jobs)
            return
        except TerminatedWorkerError:
            for number in sorted(under_way):
                yield from _alone(sweep, number)


def _alone(sweep: Sweep, number: int) -> Iterator[Record]:
    try:
        yield from _in_processes(sweep, iter([number]), set(), 1)
    except TerminatedWorkerError:
        yield failure(sweep, number, CRASHED, "the process that carried it out ended without an answer, twice")


def _in_processes(sweep: Sweep, numbers: Iterator[int], under_way: set[int], jobs: int) -> Iterator[Record]:
    """Yield records as they come; the numbers handed out and not yet answered are in `under_way`."""

    def hand_out() -> Iterator[int]:
        for number in numbers:
            under_way.add(number)
            yield number

    # One process would be this one, which must outlive a crash: two are kept, but no more rollouts than asked for
    # are under way at once.
    with parallel_config(backend="loky", inner_max_num_threads=1, idle_worker_timeout=IDLE), _deaf_to_ctrl_c():
        pool = Parallel(n_jobs=max(2, jobs), pre_dispatch=jobs, batch_size=1, return_as="generator_unordered")
        results = pool(delayed(_deafly)(roll_out, sweep, number) for number in hand_out())
    try:
        for record in results:
            under_way.discard(record["rollout"])
            yield record
    finally:
        with warnings.catch_warnings(action="ignore"):  # that rollouts are given up is intended
            results.close()


def _deafly(function: Callable[[Sweep, int], Record], sweep: Sweep, number: int) -> Record:
    """Call a function in a process that leaves Ctrl-C to its parent: what it loads may have unblocked the signal."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    return function(sweep, number)


@contextmanager
def _deaf_to_ctrl_c() -> Iterator[None]:
    """Keep Ctrl-C from the processes started meanwhile: this one ends them in order."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def on_cluster(sweep: Sweep, numbers: Iterable[int], *, address: str) -> Generator[Record, None, None]:
    """Yield the record of every rollout, as they come from the workers of a running Dask cluster.

    The scheduler gives a rollout whose worker is lost to another one, as often as its `allowed-failures` says.

    Args:
        sweep: what is swept.
        numbers: of the rollouts.
        address: of the scheduler, e.g. `tcp://127.0.0.1:8786`.

    Raises:
        PrefplanError: Dask is not installed, there is no such cluster, it has no worker or one that cannot work, or
            it went away.
    """
    try:
        from distributed import Client, as_completed
        from distributed.scheduler import KilledWorker
    except ImportError:
        raise PrefplanError(
            "--cluster: Dask is not installed; what mends it: pip install '.[cluster]', in a clone of prefplan"
        ) from None
    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise PrefplanError(f"--cluster {address}: no Dask scheduler answers ({error})") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise PrefplanError(
                f"--cluster {address}: it has no worker; start one with `dask worker {address}`"
            ) from None
        futures = client.map(partial(roll_out, sweep), list(numbers), pure=False)
        number_of = {future.key: number for future, number in zip(futures, numbers, strict=True)}
        for future in as_completed(futures):
            if future.status == "finished":
                yield future.result()
            elif future.status == "error" and isinstance(future.exception(), KilledWorker):
                yield failure(sweep, number_of[future.key], CRASHED, "the workers that carried it out were lost")
            else:
                why = future.exception() if future.status == "error" else "the scheduler went away"
                raise PrefplanError(f"--cluster {address}: {why}; what is finished is kept, start again to go on")
