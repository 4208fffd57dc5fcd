"""Jobs carried out in other processes, whose results are kept one by one."""

import signal
import warnings
from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import closing, suppress
from pathlib import Path
from typing import Any, Protocol

from joblib import Parallel, cpu_count, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError

from experiments.cli.journal import Journal
from experiments.cli.progress import Tell

RECORDS = "rollouts.jsonl"
"""File of the records, in the folder of a batch."""

IDLE_TIMEOUT_S = 20
"""A process ends after this time without work, even if its parent was killed."""

Record = dict[str, Any]
"""Result of a job, JSON-ready."""


class Batch(Protocol):
    """Numbered jobs, each a pure function of the batch and its number; a batch can be pickled.

    Attributes:
        key: the entry of a record with the number of its job.
    """

    key: str

    def record(self, number: int) -> Record:
        """Carry a job out, in a process of its own, and return its record."""

    def crashed(self, number: int, reason: str) -> Record:
        """Return the record of a job whose process ended without a result."""


def work(
    batch: Batch,
    count: int,
    path: Path,
    header: dict[str, Any],
    *,
    tell: Tell,
    stage: str,
    jobs: int | None = None,
) -> tuple[list[Record], bool]:
    """Carry the first `count` jobs of a batch out, but for those with a record, in processes: by default one per core.

    Each record is added to the `Journal` at `path`, in a folder of `only_writer`, as soon as its job is done.

    Returns:
        The records in the order of their numbers, and whether Ctrl-C ended the work.

    Raises:
        PrefplanError: the file holds other records or cannot be written.
    """
    interrupted = False
    records = Journal(path, header, key=batch.key)
    missing = [number for number in range(count) if number not in records.done]
    results = on_this_machine(batch, missing, jobs=min(jobs or cpu_count(), max(1, len(missing))))
    try:
        tell(stage, count - len(missing), count, _words(records.done))
        with closing(results):
            for done, record in enumerate(results, start=count - len(missing) + 1):
                records.add(record)
                tell(stage, done, count, _words(records.done))
    except KeyboardInterrupt:
        interrupted = True
        # Ctrl-C may have come after a record was written and before it was counted: the file decides.
        records = Journal(path, header, key=batch.key)
    return [records.done[number] for number in range(count) if number in records.done], interrupted


def _words(done: Mapping[int, Record]) -> str:
    good = sum(record.get("completed", False) for record in done.values())
    return f"{good / len(done):.1%} completed" if done else ""


def on_this_machine(batch: Batch, numbers: Iterable[int], *, jobs: int) -> Generator[Record, None, None]:
    """Yield the record of every job, in the order in which they finish.

    When a process is killed, the unfinished jobs are tried again one at a time, to find the one that kills its process,
    which is recorded as crashed.
    """
    # joblib warns when it replaces a process that has grown, and when pending jobs are cancelled.
    warnings.filterwarnings("ignore", category=UserWarning, module="joblib")
    waiting = list(numbers)
    while waiting:
        try:
            for record in _in_processes(batch, tuple(waiting), jobs):
                waiting.remove(record[batch.key])
                yield record
        except TerminatedWorkerError:
            # Jobs are handed out in order, and never more than `jobs` at a time.
            for number in waiting[:jobs]:
                waiting.remove(number)
                yield _alone(batch, number)


def _alone(batch: Batch, number: int) -> Record:
    # It may have been another job that killed the process: only crashes of this one alone count.
    for _ in range(2):
        with suppress(TerminatedWorkerError):
            (record,) = _in_processes(batch, [number], 1)
            return record
    return batch.crashed(number, "the process that carried it out ended without a result, twice")


def _in_processes(batch: Batch, numbers: Iterable[int], jobs: int) -> Iterator[Record]:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # for the processes, too: this one shuts them down
    try:
        # With n_jobs=1 joblib would use this process, which must survive a crash: so there are at least two processes,
        # but at most `jobs` jobs at a time.
        with parallel_config(backend="loky", inner_max_num_threads=1, idle_worker_timeout=IDLE_TIMEOUT_S):
            pool = Parallel(n_jobs=max(2, jobs), pre_dispatch=jobs, batch_size=1, return_as="generator_unordered")
            results = pool(delayed(batch.record)(number) for number in numbers)
    finally:
        signal.signal(signal.SIGINT, before)
    yield from results
