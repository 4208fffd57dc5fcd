"""The controls beside the scene, and how the execution stands."""

from __future__ import annotations

from collections.abc import Callable

import viser

from experiments.viewer.control import Control
from experiments.viewer.performance import LiveRun, Moment
from experiments.viewer.standing_html import standing_html

SPEEDS = ("1/4", "1/2", "1", "2", "4", "8")
"""Simulated seconds in a second."""


class Panel:
    """Buttons and text on one server; what is clicked in any browser counts for all."""

    def __init__(self, server: viser.ViserServer, title: str, *, restart: Callable[[], None]) -> None:
        """Put it up.

        Args:
            server: where to.
            title: what is carried out.
            restart: called when another performance is wanted.
        """
        self._performance: LiveRun | None = None
        self._shown: Moment | None = None
        gui = server.gui
        # Sharing would open the page to the world through somebody else's server.
        gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()
        gui.set_panel_label(title)
        self._play = gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY)
        self._pause = gui.add_button("Pause", icon=viser.Icon.PLAYER_PAUSE, visible=False)
        self._step = gui.add_button("Step", icon=viser.Icon.PLAYER_SKIP_FORWARD, hint="one action, then pause")
        self._restart = gui.add_button(
            "Restart", icon=viser.Icon.REFRESH, color="gray", hint="simulate from the beginning"
        )
        self._speed = gui.add_dropdown("Speed", SPEEDS, initial_value="1", hint="simulated seconds in a second")
        self._time = gui.add_slider(
            "Recording", min=0.0, max=1.0, step=0.01, initial_value=0.0, visible=False, hint="seconds"
        )
        self._text = gui.add_html("")
        self._play.on_click(lambda event: self._control.play())
        self._pause.on_click(lambda event: self._control.pause())
        self._step.on_click(lambda event: self._control.step())
        self._restart.on_click(lambda event: restart())
        self._speed.on_update(lambda event: setattr(self._control, "speed", self.speed))
        self._time.on_update(self._seek)

    @property
    def speed(self) -> float:
        """Simulated seconds in a second that are wanted."""
        above, _, below = self._speed.value.partition("/")
        return float(above) / float(below or 1)

    def control(self, performance: LiveRun) -> None:
        """Let the buttons act on a performance from now on."""
        self._performance = performance

    def show(self, moment: Moment) -> None:
        """Show how things stand."""
        running = self._control.mode != "paused"
        self._play.visible, self._pause.visible = not running, running
        state = "paused"
        if moment.length is None:
            self._time.visible = False
            state = "running" if running else state
        else:
            self._time.max, self._time.visible = moment.length, True
            # A slider that somebody drags is further on already than the moment they asked for.
            if moment is not self._shown and not moment.sought:
                self._time.value = round(moment.time, 2)  # type: ignore[misc]  # mypy misses the setter
            state = "replaying" if running else state
        self._shown = moment
        html = standing_html(moment.standing, moment.time, state=moment.standing.ended or state)
        if html != self._text.content:
            self._text.content = html

    @property
    def _control(self) -> Control:
        assert self._performance is not None, "`control` comes first"
        return self._performance.control

    def _seek(self, event: viser.GuiEvent[viser.GuiSliderHandle[float]]) -> None:
        """Go where somebody drags the slider; that it moves as the recording plays is no wish."""
        if event.client is not None:
            self._control.seek(self._time.value)
