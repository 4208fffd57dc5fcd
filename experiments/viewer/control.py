"""What the spectator wants of a performance: play, pause, one action at a time, faster or slower, another moment."""

from __future__ import annotations

import threading
import time
from typing import Literal

LATENESS = 0.1
"""A performance that is later than this, s, does not hurry to make up for it: planning again takes its time."""

Mode = Literal["paused", "playing", "stepping"]


class Stopped(Exception):
    """The spectator wants no more of this performance."""


class Control:
    """Between the spectator, whose wishes come at any time, and one performance, which waits in `keep_time`."""

    def __init__(self) -> None:
        """Begin paused, at real speed."""
        self._changed = threading.Condition()
        self._mode: Mode = "paused"
        self._speed = 1.0
        self._sought: float | None = None
        self._stopped = False
        self._anchor: tuple[float, float] | None = None

    @property
    def mode(self) -> Mode:
        """What the performance is to do now."""
        return self._mode

    @property
    def speed(self) -> float:
        """Simulated seconds in a second."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        with self._changed:
            self._speed, self._anchor = speed, None
            self._changed.notify_all()

    def play(self) -> None:
        """Go on."""
        self._set("playing")

    def pause(self) -> None:
        """Hold still."""
        self._set("paused")

    def step(self) -> None:
        """Go on until the action that runs, or else the next, has ended."""
        self._set("stepping")

    def stop(self) -> None:
        """End the performance."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()

    def seek(self, moment: float) -> None:
        """Hold still at another moment of a recording, s."""
        with self._changed:
            self._mode, self._anchor, self._sought = "paused", None, moment
            self._changed.notify_all()

    def end_action(self) -> None:
        """Take note that an action has ended, the performance's side of `step`."""
        with self._changed:
            if self._mode == "stepping":
                self._mode = "paused"

    def keep_time(self, moment: float) -> float | None:
        """Wait until it is time for a moment of the performance; as long as it is paused, that is never.

        Args:
            moment: simulated time, s.

        Returns:
            The moment that the spectator seeks instead, or None.

        Raises:
            Stopped: the spectator wants no more.
        """
        with self._changed:
            while True:
                if self._stopped:
                    raise Stopped
                if self._sought is not None:
                    sought, self._sought = self._sought, None
                    return sought
                if self._mode == "paused":
                    self._anchor = None
                    self._changed.wait()
                    continue
                ahead = self._ahead(moment, time.monotonic())
                if ahead <= 0:
                    return None
                self._changed.wait(ahead)

    def _ahead(self, moment: float, now: float) -> float:
        """Return for how long a moment is still to come, s."""
        if self._anchor is not None:
            began, first = self._anchor
            ahead = began + (moment - first) / self._speed - now
            if ahead > -LATENESS:
                return ahead
        self._anchor = (now, moment)
        return 0.0

    def _set(self, mode: Mode) -> None:
        with self._changed:
            self._mode = mode
            self._changed.notify_all()
