"""The controls beside the scene: playback, the front, the user's faults, and the status of the runs."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Literal

import viser

from experiments.cli.browser import template
from prefplan.plan import objectives_text

if TYPE_CHECKING:
    from experiments.viewer.session import Session

SPEEDS = {"1/4": 0.25, "1/2": 0.5, "1": 1.0, "2": 2.0, "4": 4.0, "8": 8.0}
"""Simulated seconds per second."""

BLIND_S = 2.0
"""Time for which one click blinds the camera, s; the robot waits longer."""

TO_OBJECT = {"Knock over": "knock", "Move away": "move"}
"""Kinds of faults that happen to an object, by their buttons."""

TO_ARM = {"Drop what it holds": ("slip", ""), f"Blind {BLIND_S:g} s": ("blind", f"{BLIND_S:g}")}
"""Kinds of faults that happen to the arm, and their arguments, by their buttons."""

COLOURS: dict[Literal["blue", "orange"], str] = {"blue": "#228be6", "orange": "#fd7e14"}
"""Colours of the left and the right plan: viser's names, and their codes for HTML."""

HINT = "<div style='padding: 0 1em; font-size: 0.8em'>Drag an object, or Shift-click it to knock it over.</div>"

ALONE = "no other plan"
"""The choice under `Beside it` that shows a single arm."""


class Panel:
    """Buttons and text on one server, shared by all browsers."""

    def __init__(self, server: viser.ViserServer, session: Session) -> None:
        """Add the controls to the page of a session."""
        self._session, self._playback = session, session.playback
        gui = self._gui = server.gui
        # Sharing would publish the page through another server.
        gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()
        gui.set_panel_label(session.show.title)
        self._add_playback()
        with gui.add_folder("Front"):
            self._add_front()
        with gui.add_folder("Inject faults"):
            self._add_faults()
        self._text = gui.add_html("")

    def update(self, shown: Sequence[int]) -> None:
        """Show the current time, and the status of the plans with these indices; viser sends only what differs."""
        playback = self._playback
        self._play.visible = not playback.playing
        self._pause.visible = playback.playing
        self._time.max = max(round(max(run.latest for run in playback.runs), 2), 0.01)
        # While a user drags the slider, its value is newer than the time shown.
        if not playback.sought:
            self._time.value = round(playback.time, 2)  # type: ignore[misc]  # mypy misses the setter
        # If both are the same plan, its row has the colour of the left one.
        colours = dict(reversed([*zip(shown, COLOURS, strict=False)]))
        for i, row in enumerate(self._rows):
            row.color = colours.get(i, "gray")
        runs = zip(playback.runs, shown, COLOURS.values(), strict=False)
        page = template(__package__, "panel.html")
        self._text.content = page.render(runs=[*runs], time=playback.time, playing=playback.playing)

    def _add_playback(self) -> None:
        gui, playback, session = self._gui, self._playback, self._session
        self._play = gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY, hint="continue the simulation")
        pause = "stop the simulation for a while"
        self._pause = gui.add_button("Pause", icon=viser.Icon.PLAYER_PAUSE, visible=False, hint=pause)
        more = gui.add_button_group("", ("Step", "Restart"), hint="Step: play one action. Restart: from the start.")
        speed = gui.add_dropdown("Speed", tuple(SPEEDS), initial_value="1", hint="simulated seconds per second")
        self._time = gui.add_slider("Time", min=0.0, max=0.01, step=0.01, initial_value=0.0, hint="simulated seconds")
        self._play.on_click(lambda event: playback.play())
        self._pause.on_click(lambda event: playback.pause())
        more.on_click(lambda event: playback.step() if more.value == "Step" else session.restart())
        speed.on_update(lambda event: setattr(playback, "speed", SPEEDS[speed.value]))
        self._time.on_update(self._seek)

    def _add_front(self) -> None:
        gui, session = self._gui, self._session
        labels = [f"{i}: {objectives_text(plan)}" for i, plan in enumerate(session.show.plans)]
        self._rows = [gui.add_button(text, color="gray", hint="carry out this plan from the start") for text in labels]
        for i, row in enumerate(self._rows):
            row.on_click(partial(lambda i, event: session.choose(i), i))
        beside = {ALONE: None} | {text: i for i, text in enumerate(labels)}
        other = gui.add_dropdown("Beside it", tuple(beside), initial_value=ALONE, hint="another plan, by a second arm")
        other.on_update(lambda event: session.beside(beside[other.value]))

    def _add_faults(self) -> None:
        gui, session, model = self._gui, self._session, self._session.show.scene.model
        objects = {model.display.obj(obj.name): obj.name for obj in model.objects}
        gui.add_html(HINT)
        obj = gui.add_dropdown(
            "Object", tuple(objects), initial_value=next(iter(objects)), hint="what the next row disturbs"
        )
        to_object = gui.add_button_group("It", tuple(TO_OBJECT), hint="disturb the object")
        to_arm = gui.add_button_group("The arm", tuple(TO_ARM), hint="disturb the arm or its camera")
        to_object.on_click(lambda event: session.inject(TO_OBJECT[to_object.value], objects[obj.value]))
        to_arm.on_click(lambda event: session.inject(*TO_ARM[to_arm.value]))

    def _seek(self, event: viser.GuiEvent[viser.GuiSliderHandle[float]]) -> None:
        """Seek to the time to which a user drags the slider; if the program moves it, the event has no client."""
        if event.client is not None:
            self._playback.seek(self._time.value)
