"""A plan carried out in a thread of its own, and what the viewer plays of it: frames, and the costs between actions."""

from __future__ import annotations

import bisect
import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from experiments.runs.outcome import ledger_of
from prefplan.front import Plan
from prefplan.ledger import Entry
from prefplan.problem import Problem
from sim.execution.closed_loop import ClosedLoop
from sim.simulation.rollout import FRAME_RATE

STOP_TIMEOUT_S = 2.0
"""Longest wait for the thread's end: planning after a surprise is not interrupted."""

NEWS = {"fault": "fault", "replan": "planned again", "retry": "tried again", "ended": "given up"}
"""The events to show, and their words."""

Begin = Callable[[Callable[[int, int, str], None]], ClosedLoop]
"""Returns the pursuit of a plan at its start, given what to call before each action."""


@dataclass(frozen=True)
class Frame:
    """A recorded state of the scene.

    Attributes:
        time: simulated time, s.
        qpos: (nq,) positions of the scene's MuJoCo model.
        glow: index of the marking location at work, -1 for none.
    """

    time: float
    qpos: np.ndarray
    glow: int


@dataclass(frozen=True)
class Status:
    """The status of a run between two actions.

    Attributes:
        time: simulated time, s.
        plan: the plan followed now; it begins with the actions done.
        done: number of actions done.
        costs: what they cost, and what the preference makes of it.
        news: a line for each fault, new plan and new attempt so far.
        ended: `completed`, or why the run ended before; None while it goes on.
    """

    time: float
    plan: Plan
    done: int
    costs: Entry
    news: tuple[str, ...] = ()
    ended: str | None = None


class _Stopped(Exception):
    """The run is not wanted any more."""


class LiveRun(threading.Thread):
    """One run of a plan, simulated as fast as possible.

    Attributes:
        problem: what was planned.
        frames: so far, `FRAME_RATE` a second.
        statuses: at the start, before each action and at the end.
        failure: the error that ended the thread, or None.
    """

    def __init__(self, problem: Problem, begin: Begin) -> None:
        """Prepare the thread.

        Args:
            problem: what was planned.
            begin: called in the thread.
        """
        super().__init__(daemon=True)
        self.problem = problem
        self.frames: list[Frame] = []
        self.statuses: list[Status] = []
        self.failure: Exception | None = None
        self._begin = begin
        self._stopping = threading.Event()

    def run(self) -> None:
        """Carry the plan out."""
        try:
            loop = self._begin(lambda done, total, action: self._note(loop) if action else None)
            cell = loop.run.cell
            inject_faults = cell.disturb

            def before_period() -> None:
                if self._stopping.is_set():
                    raise _Stopped
                if not self.frames or float(cell.data.time) >= self.frames[-1].time + 1 / FRAME_RATE - 1e-6:
                    self._record(loop)
                inject_faults()

            cell.disturb = before_period
            self._note(loop)
            self._record(loop)
            loop.pursue()
            self._note(loop, ended=loop.run.reason or "completed")
            self._record(loop)
        except _Stopped:
            pass
        except Exception as failure:
            # A thread has no caller to raise to: the session looks here.
            self.failure = failure

    def stop(self) -> None:
        """End the simulation, and wait for that."""
        self._stopping.set()
        if self.is_alive():
            self.join(STOP_TIMEOUT_S)

    @property
    def ended(self) -> bool:
        """Whether the last frame is recorded."""
        return bool(self.statuses and self.statuses[-1].ended and self.frames[-1].time >= self.statuses[-1].time)

    def frame_at(self, time: float) -> Frame:
        """Return the last frame up to a time, s, or the first one."""
        return self.frames[max(bisect.bisect_right(self.frames, time, key=lambda frame: frame.time) - 1, 0)]

    def status_at(self, time: float) -> Status:
        """Return the last status up to a time, s, or the first one."""
        return self.statuses[max(bisect.bisect_right(self.statuses, time, key=lambda status: status.time) - 1, 0)]

    def _record(self, loop: ClosedLoop) -> None:
        cell = loop.run.cell
        self.frames.append(Frame(float(cell.data.time), cell.data.qpos.copy(), cell.glowing))

    def _note(self, loop: ClosedLoop, *, ended: str | None = None) -> None:
        run, plan = loop.run, loop.plan
        news = [
            f"{event.time:.1f} s: {NEWS[event.kind]}: {event.detail['fault' if event.kind == 'fault' else 'reason']}"
            for event in run.cell.events
            if event.kind in NEWS
        ]
        costs = ledger_of(self.problem, plan, run.steps).final
        self.statuses.append(Status(float(run.cell.data.time), plan, len(run.steps), costs, tuple(news), ended))
