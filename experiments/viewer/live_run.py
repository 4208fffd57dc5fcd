"""A plan carried out in a separate thread, in step with the viewer, while a user may disturb it."""

import bisect
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from experiments.runs.outcome import NEWS, news_of
from prefplan import Entry, Plan, Problem
from sim import ClosedLoop, Fault, Observer
from sim.execution.faults.fault import kinds
from sim.execution.pull import Pull
from sim.simulation.plant import Plant
from sim.simulation.run import ledger_of

STOP_TIMEOUT_S = 2.0
"""Longest wait for the thread to end, s: planning after a mismatch is not interrupted."""

Begin = Callable[[Callable[[int, int, str], None]], ClosedLoop]
"""Returns the closed loop of a plan at its start, given a function to call before each action."""


@dataclass(frozen=True)
class Status:
    """The status of a run at the start of an action, or at an event.

    Attributes:
        time: simulated time, s.
        plan: the current plan; it begins with the actions done.
        done: number of actions done.
        costs: the ledger's entry after these actions.
        news: a line for each fault, new plan, retry and freed or turned object so far.
        ended: `completed`, or why the run ended early; None while it is running.
    """

    time: float
    plan: Plan
    done: int
    costs: Entry
    news: tuple[str, ...] = ()
    ended: str | None = None


class LiveRun(threading.Thread, Observer):
    """One run of a plan, simulated as fast as possible up to the time allowed.

    Attributes:
        problem: the problem of the plan.
        frames: recorded so far, see `sim.simulation.recorder.Recorder`; none before the run has begun.
        statuses: at the start, before each action, at each event of a kind in `NEWS` and at the end.
        waiting: the user's faults that happen when the simulation continues.
        pull: how the user pulls an object.
        failure: the error that ended the thread, or None.
    """

    def __init__(self, problem: Problem, begin: Begin, *, until: float = np.inf) -> None:
        """Prepare the thread, which calls `begin`, simulates up to the time `until`, s, and then waits for `allow`."""
        super().__init__(daemon=True)
        self.problem = problem
        self.frames: list[dict[str, Any]] = []
        self.statuses: list[Status] = []
        self.waiting: deque[Fault] = deque()
        self.pull = Pull()
        self.failure: Exception | None = None
        self._begin = begin
        self._until = until
        self._changed = threading.Condition()
        self._stopping = False

    def run(self) -> None:
        """Carry the plan out."""
        try:
            self._loop = loop = self._begin(lambda done, total, action: self._note() if action else None)
            loop.execution.cell.observers[:0] = [self, self.pull]
            self._note()
            cell, self.frames = loop.execution.cell, loop.execution.cell.recorder.frames
            loop.run()
            self._note(ended=loop.record().reason or "completed")
            cell.recorder.record(cell.data, glow=cell.glowing)
        except SystemExit:
            pass
        except Exception as failure:
            # A thread has no caller to raise to: the session checks this attribute.
            self.failure = failure

    def allow(self, time: float) -> None:
        """Let the simulation continue at least to a time, s."""
        with self._changed:
            self._until = max(self._until, time)
            self._changed.notify()

    def inject(self, kind: str, argument: str = "") -> None:
        """Let a `Fault` happen as soon as the simulation continues, or log why it cannot; no effect after the end."""
        if not (self.statuses and self.statuses[-1].ended):
            self.waiting.append(kinds()[kind](1, argument))

    def stop(self, wait: float = STOP_TIMEOUT_S) -> None:
        """End the simulation soon, and wait at most this time, s, for its thread."""
        with self._changed:
            self._stopping = True
            self._changed.notify()
        if self.is_alive():
            self.join(wait)

    @property
    def ended(self) -> bool:
        """Whether the last frame is recorded."""
        return bool(self.statuses and self.statuses[-1].ended and self.latest >= self.statuses[-1].time)

    @property
    def latest(self) -> float:
        """The time of the last frame, s; 0 before the first one."""
        return float(self.frames[-1]["times"]) if self.frames else 0.0

    def frame_at(self, time: float) -> dict[str, Any]:
        """Return the last frame up to a time, s, or the first one."""
        return self.frames[max(bisect.bisect_right(self.frames, time, key=lambda frame: frame["times"]) - 1, 0)]

    def status_at(self, time: float) -> Status:
        """Return the last status up to a time, s, or the first one."""
        return self.statuses[max(bisect.bisect_right(self.statuses, time, key=lambda status: status.time) - 1, 0)]

    def before_period(self, cell: Plant) -> None:
        """Wait until more time is allowed, and apply the user's faults and pulls."""
        run = self._loop.execution
        now = float(cell.data.time)
        with self._changed:
            self._changed.wait_for(lambda: self._stopping or now < self._until)
        if self._stopping:
            raise SystemExit
        self.pull.action = action = len(run.steps) + 1
        while self.waiting:
            fault = replace(self.waiting.popleft(), action=action)
            if not run.injector.inject(fault):
                run.cell.log_event("refused", fault=str(fault), reason=fault.refusal)
        if sum(event.kind in NEWS for event in run.cell.events) > len(self.statuses[-1].news):
            self._note()

    def _note(self, *, ended: str | None = None) -> None:
        run, plan = self._loop.execution, self._loop.plan
        costs = ledger_of(self.problem, plan, run.steps).final
        news = tuple(news_of(run.cell.events, self.problem.display))
        self.statuses.append(Status(float(run.cell.data.time), plan, len(run.steps), costs, news, ended))
