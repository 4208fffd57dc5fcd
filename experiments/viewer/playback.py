"""The playhead of the runs shown: play, pause, one action at a time, faster or slower, another time."""

from __future__ import annotations

import threading
from collections.abc import Sequence

from experiments.viewer.live_run import LiveRun

LEAD_S = 0.1
"""Simulated time that runs may be ahead of what is shown: meddling is seen at once, and a slow period is not."""


class Playback:
    """The time that is shown of one run, or of several in step. It never passes what is simulated of any.

    Runs are simulated as it goes on. Buttons may move it from any thread.

    Attributes:
        runs: what is played; each has a frame at least.
        time: shown now, simulated, s.
        speed: simulated seconds in a second.
        playing: whether the time goes on.
        sought: whether the time is one that the user asked for.
    """

    def __init__(self, runs: Sequence[LiveRun] = ()) -> None:
        """Begin paused at the start."""
        self.runs = tuple(runs)
        self.time = 0.0
        self.speed = 1.0
        self.playing = self.sought = False
        self._stop_after: dict[LiveRun, int] = {}
        self._lock = threading.Lock()

    @property
    def latest(self) -> float:
        """The latest time that can be shown, s: that of the run that is behind, of those that go on."""
        going = [run.frames[-1].time for run in self.runs if not run.ended]
        return min(going) if going else max(run.frames[-1].time for run in self.runs)

    @property
    def ended(self) -> bool:
        """Whether every run has ended."""
        return all(run.ended for run in self.runs)

    def load(self, runs: Sequence[LiveRun], *, playing: bool) -> None:
        """Show other runs from their start."""
        with self._lock:
            self.runs, self.time, self.playing, self.sought, self._stop_after = tuple(runs), 0.0, playing, False, {}

    def play(self) -> None:
        """Play on; from the end, play from the start again."""
        with self._lock:
            if self.ended and self.time >= self.latest:
                self.time = 0.0
            self.playing, self.sought, self._stop_after = True, False, {}

    def pause(self) -> None:
        """Hold still."""
        self.playing = False

    def step(self) -> None:
        """Play to the next end of an action of any run."""
        self.play()
        with self._lock:
            self._stop_after = {run: run.status_at(self.time).done + 1 for run in self.runs}

    def seek(self, time: float) -> None:
        """Hold still at another time, s."""
        with self._lock:
            self.time, self.playing, self.sought = time, False, True

    def catch_up(self) -> None:
        """Show the present of the simulation, where a user can meddle."""
        with self._lock:
            self.time, self.sought = max(self.time, self.latest), False

    def advance(self, seconds: float) -> None:
        """Let some real time pass, s."""
        with self._lock:
            if not self.playing:
                return
            first = max(run.frames[0].time for run in self.runs)
            time = max(self.time, first) + seconds * self.speed
            for run in self.runs:
                run.allow(time + LEAD_S)
            ended, latest = self.ended, self.latest
            stops = [s.time for run, done in self._stop_after.items() for s in run.statuses if s.done == done]
            if stops and time >= min(stops):
                time, self.playing = min(stops), False
            elif time >= latest:
                time, self.playing = latest, not ended
            self.time = time
