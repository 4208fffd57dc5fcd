"""A plan carried out in a thread of its own at the spectator's pace, and afterwards shown again from its recording."""

from __future__ import annotations

import bisect
import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from experiments.viewer.control import Control, Stopped
from experiments.viewer.standing import Standing, standing
from prefplan.problem import Problem
from sim.execution.closed_loop import ClosedLoop
from sim.simulation.workcell import Workcell

STOPPING = 2.0
"""How long a performance is waited for that nobody wants any more, s."""

Begin = Callable[[Callable[[int, int, str], None]], ClosedLoop]
"""Returns the pursuit of a plan at its start, given whom it tells before each action what is done."""


@dataclass(frozen=True)
class Moment:
    """What is to be seen at one time.

    Attributes:
        time: simulated time, s.
        qpos: (nq,) positions of the scene's MuJoCo model.
        glow: index of the marking location at work, -1 for none.
        standing: how the execution stands.
        length: of the recording in all, s; None while it is still made.
        sought: whether the spectator has asked for this moment of the recording.
    """

    time: float
    qpos: np.ndarray
    glow: int
    standing: Standing
    length: float | None = None
    sought: bool = False


class LiveRun(threading.Thread):
    """One execution of a plan, live; when it has ended, its recording.

    Attributes:
        control: what the spectator wants of it.
        moment: what is to be seen now; None until there is anything.
        failure: what ended the thread although nobody wanted that, or None.
    """

    def __init__(self, problem: Problem, begin: Begin, *, speed: float = 1.0) -> None:
        """Prepare a performance, which begins paused.

        Args:
            problem: what was planned.
            begin: called in the thread.
            speed: simulated seconds in a second.
        """
        super().__init__(daemon=True)
        self._problem, self._begin = problem, begin
        self.control = Control()
        self.control.speed = speed
        self.moment: Moment | None = None
        self.failure: BaseException | None = None
        self._standings: list[Standing] = []

    def run(self) -> None:
        """Carry the plan out, then replay it for as long as anybody wants to."""
        try:
            self._replay(self._perform())
        except Stopped:
            pass
        except BaseException as failure:
            # A thread has nobody to raise to: whoever started it looks here.
            self.failure = failure

    def stop(self) -> None:
        """End it, and wait for that, but not for a plan that is being made anew."""
        self.control.stop()
        self.join(STOPPING)

    def _perform(self) -> ClosedLoop:
        """Carry the plan out, keeping the spectator's time in every control period."""
        loop = self._begin(lambda done, total, action: self._between(loop, action))
        cell = loop.run.cell
        simulate_faults = cell.disturb

        def tick() -> None:
            self._show(cell)
            self.control.keep_time(float(cell.data.time))
            simulate_faults()

        self._standings.append(standing(self._problem, loop))
        cell.disturb = tick
        loop.pursue()
        self._standings.append(standing(self._problem, loop, ended=loop.run.reason or "completed"))
        return loop

    def _between(self, loop: ClosedLoop, action: str) -> None:
        """Look at how things stand before an action, and wait there if the spectator wants that."""
        if not action:
            return
        self._standings.append(standing(self._problem, loop))
        self._show(loop.run.cell)
        if loop.run.steps:
            self.control.end_action()
        self.control.keep_time(float(loop.run.cell.data.time))

    def _show(self, cell: Workcell) -> None:
        """Let the present be seen."""
        self.moment = Moment(float(cell.data.time), cell.data.qpos.copy(), cell.glowing, self._standings[-1])

    def _replay(self, loop: ClosedLoop) -> None:
        """Show the recording, from where the spectator likes; played on from its end, it begins again."""
        recorded = loop.run.cell.recorder.arrays
        times, end = recorded["times"], self._standings[-1].time
        starts = [held.time for held in self._standings]
        held = [self._standings[max(bisect.bisect_right(starts, time) - 1, 0)] for time in times]
        # The last frame is recorded shortly before the end.
        held[-1] = self._standings[-1]
        frame = before = last = len(times) - 1
        sought: float | None = None
        while True:
            time = end if frame == last else float(times[frame])
            self.moment = Moment(
                time, recorded["qpos"][frame], int(recorded["glow"][frame]), held[frame], end, sought is not None
            )
            if frame == last:
                self.control.pause()
            elif frame == before + 1 and held[frame].done > held[before].done:
                self.control.end_action()
            sought = self.control.keep_time(time)
            before = frame
            if sought is not None:
                frame = before = min(int(np.searchsorted(times, sought)), last)
            else:
                frame = 0 if frame == last else frame + 1
