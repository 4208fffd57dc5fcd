"""The playhead of the runs shown: play, pause, step by one action, set the speed, seek."""

import threading
from collections.abc import Sequence

from experiments.viewer.live_run import LiveRun

LEAD_S = 0.1
"""Simulated time that runs may be ahead of the playhead, s: hides a slow control period, yet faults show at once."""


class Playback:
    """The playhead of one run, or of several in step; it never passes the simulated time of a run that has not ended.

    Runs are simulated as it advances. All methods may be called from any thread.

    Attributes:
        runs: the runs shown; each has at least one frame.
        time: simulated time shown, s.
        speed: simulated seconds per second.
        playing: whether the time advances.
        sought: whether the user chose the time.
    """

    def __init__(self, runs: Sequence[LiveRun] = ()) -> None:
        """Begin paused at the start."""
        self.speed = 1.0
        self._stop_after: dict[LiveRun, int] = {}
        self._lock = threading.Lock()
        self.load(runs, playing=False)

    @property
    def latest(self) -> float:
        """The latest time that can be shown, s: that of the slowest run that has not ended."""
        going = [run.latest for run in self.runs if not run.ended]
        return min(going) if going else max(run.latest for run in self.runs)

    @property
    def ended(self) -> bool:
        """Whether every run has ended."""
        return all(run.ended for run in self.runs)

    def load(self, runs: Sequence[LiveRun], *, playing: bool) -> None:
        """Show other runs from their start."""
        with self._lock:
            self.runs, self.time, self.playing, self.sought, self._stop_after = tuple(runs), 0.0, playing, False, {}

    def play(self) -> None:
        """Play; from the end, play again from the start."""
        with self._lock:
            if self.ended and self.time >= self.latest:
                self.time = 0.0
            self.playing, self.sought, self._stop_after = True, False, {}

    def pause(self) -> None:
        """Pause."""
        self.playing = False

    def step(self) -> None:
        """Play to the next end of an action in any run."""
        self.play()
        with self._lock:
            self._stop_after = {run: run.status_at(self.time).done + 1 if run.statuses else 1 for run in self.runs}

    def seek(self, time: float) -> None:
        """Pause at another time, s."""
        with self._lock:
            self.time, self.playing, self.sought = time, False, True

    def catch_up(self) -> None:
        """Show the current state of the simulation, the only one that a user can disturb."""
        with self._lock:
            self.time, self.sought = max(self.time, self.latest), False

    def advance(self, seconds: float) -> None:
        """Advance by some real time, s."""
        with self._lock:
            if not self.playing:
                return
            first = max(run.frames[0]["times"] for run in self.runs)
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
