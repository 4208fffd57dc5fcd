"""The controls beside the scene, and the status of the run."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from importlib.resources import files

import jinja2
import viser

from experiments.cli.output import number
from experiments.viewer.live_run import Status
from experiments.viewer.playback import Playback
from prefplan.problem import Task

SPEEDS = {"1/4": 0.25, "1/2": 0.5, "1": 1.0, "2": 2.0, "4": 4.0, "8": 8.0}
"""Simulated seconds in a second."""


class Panel:
    """Buttons and text on one server; what is clicked in any browser counts for all."""

    def __init__(self, server: viser.ViserServer, title: str, playback: Playback) -> None:
        """Put it up.

        Args:
            server: where to.
            title: what is carried out.
            playback: what the buttons act on.
        """
        self._playback = playback
        gui = server.gui
        # Sharing would publish the page through another server.
        gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()
        gui.set_panel_label(title)
        self._play = gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY)
        self._pause = gui.add_button("Pause", icon=viser.Icon.PLAYER_PAUSE, visible=False)
        step = gui.add_button("Step", icon=viser.Icon.PLAYER_SKIP_FORWARD, hint="one action, then pause")
        restart = gui.add_button("Restart", icon=viser.Icon.REFRESH, color="gray", hint="back to the start")
        speed = gui.add_dropdown("Speed", tuple(SPEEDS), initial_value="1", hint="simulated seconds in a second")
        self._time = gui.add_slider("Time", min=0.0, max=0.01, step=0.01, initial_value=0.0, hint="simulated seconds")
        self._text = gui.add_html("")
        self._play.on_click(lambda event: playback.play())
        self._pause.on_click(lambda event: playback.pause())
        step.on_click(lambda event: playback.step())
        restart.on_click(lambda event: playback.restart())
        speed.on_update(lambda event: setattr(playback, "speed", SPEEDS[speed.value]))
        self._time.on_update(self._seek)

    def update(self) -> None:
        """Show the present time and status."""
        playback, run = self._playback, self._playback.run
        self._play.visible, self._pause.visible = not playback.playing, playback.playing
        self._time.max = max(round(run.frames[-1].time, 2), 0.01)
        # While somebody drags the slider, it is ahead of the time they asked for.
        if not playback.sought:
            self._time.value = round(playback.time, 2)  # type: ignore[misc]  # mypy misses the setter
        html = status_html(
            run.problem.tasks,
            run.status_at(playback.time),
            playback.time,
            state="playing" if playback.playing else "paused",
        )
        if html != self._text.content:
            self._text.content = html

    def _seek(self, event: viser.GuiEvent[viser.GuiSliderHandle[float]]) -> None:
        """Show the time to which somebody drags the slider; the program itself moves it without a client."""
        if event.client is not None:
            self._playback.seek(self._time.value)


def status_html(tasks: Sequence[Task], status: Status, time: float, *, state: str) -> str:
    """Return the status of a run as HTML.

    Args:
        tasks: the problem's.
        status: of the run.
        time: simulated, s.
        state: whether it plays or is paused; at the end, why the run ended is shown instead.
    """
    return _template().render(
        tasks=tasks,
        status=status,
        plan=status.plan,
        costs=status.costs,
        time=time,
        state=status.ended or state,
    )


@cache
def _template() -> jinja2.Template:
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    environment.filters["number"] = number
    return environment.from_string(files(__package__).joinpath("panel.html").read_text("utf-8"))
