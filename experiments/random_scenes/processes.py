"""Independent jobs, each in a process of its own that is ended when its time is up."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

Record = dict[str, Any]
"""Result of a job, JSON-ready."""

Job = Callable[..., Record]
"""Gets what all jobs share, its number and a function that reports early entries of its record; returns the others."""


@dataclass
class _Running:
    """A job's number, its process, the time at which that is ended, and what it has reported."""

    number: int
    process: BaseProcess
    end: float
    known: Record


def in_processes(
    job: Job,
    shared: tuple[Any, ...],
    numbers: Iterable[int],
    *,
    jobs: int,
    max_seconds: float,
    timed_out: Record,
    crashed: Record,
) -> Iterator[tuple[int, Record]]:
    """Yield the number and the record of every job, in the order in which they end.

    When the caller stops, or after Ctrl-C, the running processes are ended.

    Args:
        job: a function of a module, which is loaded only once.
        shared: first arguments of every job.
        numbers: of the jobs.
        jobs: greatest number of processes at a time.
        max_seconds: time limit of one job, s.
        timed_out: entries to add to what a job reported before its time was up.
        crashed: likewise for a job whose process ended without a result.
    """
    context, running, waiting = get_context("forkserver"), dict[Connection, _Running](), iter(numbers)
    context.set_forkserver_preload([job.__module__])
    try:
        while True:
            while len(running) < jobs and (number := next(waiting, None)) is not None:
                receiver, sender = context.Pipe(duplex=False)
                process = context.Process(target=_do, args=(job, shared, number, sender), daemon=True)
                process.start()
                sender.close()
                running[receiver] = _Running(number, process, time.monotonic() + max_seconds, {})
            if not running:
                return
            wait(list(running), timeout=max(0.0, min(one.end for one in running.values()) - time.monotonic()))
            for receiver, one in list(running.items()):
                ending = _news(receiver, one.known, crashed)
                if ending is None and time.monotonic() >= one.end:
                    ending = timed_out
                if ending is not None:
                    _end(running.pop(receiver).process)
                    yield one.number, one.known | ending
    finally:
        for one in running.values():
            _end(one.process)


def _news(receiver: Connection, known: Record, crashed: Record) -> Record | None:
    """Add what a job has reported to what is known; return the last entries if it has ended, else None."""
    try:
        while receiver.poll():
            last, entries = receiver.recv()
            if last:
                return entries  # type: ignore[no-any-return]
            known.update(entries)
    except EOFError:
        return crashed
    return None


def _end(process: BaseProcess) -> None:
    process.kill()
    process.join()


def _do(job: Job, shared: tuple[Any, ...], number: int, sender: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends this process after Ctrl-C
    sender.send((True, job(*shared, number, lambda entries: sender.send((False, entries)))))
