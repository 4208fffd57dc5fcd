"""The playhead of a run: play, pause, one action at a time, faster or slower, another time."""

from __future__ import annotations

import threading

from experiments.viewer.live_run import LiveRun


class Playback:
    """The time of a run that is shown. It never passes what is simulated; buttons may move it from any thread.

    Attributes:
        run: what is played.
        time: shown now, simulated, s.
        speed: simulated seconds in a second.
        playing: whether the time goes on.
        sought: whether the time is one that the user asked for.
    """

    def __init__(self, run: LiveRun) -> None:
        """Begin paused at the start."""
        self.run = run
        self.time = 0.0
        self.speed = 1.0
        self.playing = self.sought = False
        self._stop_after: int | None = None
        self._lock = threading.Lock()

    def play(self) -> None:
        """Play on; from the end, play from the start again."""
        with self._lock:
            if self.run.ended and self.time >= self.run.frames[-1].time:
                self.time = 0.0
            self.playing, self.sought, self._stop_after = True, False, None

    def pause(self) -> None:
        """Hold still."""
        self.playing = False

    def step(self) -> None:
        """Play to the end of the present action."""
        self.play()
        with self._lock:
            self._stop_after = self.run.status_at(self.time).done + 1

    def seek(self, time: float) -> None:
        """Hold still at another time, s."""
        with self._lock:
            self.time, self.playing, self.sought = time, False, True

    def restart(self) -> None:
        """Hold still at the start."""
        self.seek(0.0)
        self.sought = False

    def advance(self, seconds: float) -> None:
        """Let some real time pass, s."""
        with self._lock:
            if not self.playing:
                return
            run = self.run
            ended, first, last = run.ended, run.frames[0].time, run.frames[-1].time
            time = max(self.time, first) + seconds * self.speed
            stops = [status.time for status in run.statuses if status.done == self._stop_after]
            if stops and time >= stops[0]:
                time, self.playing = stops[0], False
            elif time >= last:
                time, self.playing = last, not ended
            self.time = time
