"""Jobs carried out in other processes, whose results are kept one by one."""

import warnings
from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import closing, suppress
from pathlib import Path
from typing import Any, Protocol

from joblib import cpu_count, delayed
from joblib.externals.loky.process_executor import TerminatedWorkerError

from experiments.cli.journal import Journal
from experiments.cli.progress import Tell
from sim.processes import in_processes

RECORDS = "rollouts.jsonl"
"""File of the records, in the folder of a batch."""

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
    """Carry out the first `count` jobs of a batch that have no record yet, in processes (by default one per core).

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
            for record in _records(batch, tuple(waiting), jobs):
                waiting.remove(record[batch.key])
                yield record
        except TerminatedWorkerError:
            # Jobs are handed out in order, and never more than `jobs` at a time.
            for number in waiting[:jobs]:
                waiting.remove(number)
                yield _alone(batch, number)


def _alone(batch: Batch, number: int) -> Record:
    # Another job may have killed the process: only crashes of this job alone count.
    for _ in range(2):
        with suppress(TerminatedWorkerError):
            (record,) = _records(batch, [number], 1)
            return record
    return batch.crashed(number, "the process that carried it out ended without a result, twice")


def _records(batch: Batch, numbers: Iterable[int], jobs: int) -> Iterator[Record]:
    return in_processes((delayed(batch.record)(number) for number in numbers), jobs=jobs)
