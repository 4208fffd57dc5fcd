"""A server for browsers, and the runs that play on it."""

import base64
import contextlib
import io
import json
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.resources import files

import numpy as np
import viser
from viser import _messages

from experiments.viewer.door import HOST, Door
from experiments.viewer.live_run import Begin, LiveRun
from experiments.viewer.panel import Panel
from experiments.viewer.playback import Playback
from experiments.viewer.stage import Stage
from experiments.viewer.viewpoint import Viewpoint
from prefplan import Plan, PrefplanError, Problem
from sim.rendering.cameras import AZIMUTH_DEG
from sim.world.scene import Scene

DEFAULT_PORT = 8080

REFRESH_S = 1 / 30
"""Time between two updates of the picture, s."""

GAP_M = 0.1
"""Gap between two tables beside each other, m."""


@dataclass(frozen=True)
class Show:
    """What a page shows: the front of a problem, and the scene in which its plans are carried out.

    Attributes:
        plans: the front.
        start: returns the function that begins a plan, given the plan's index.
        chosen: index of the plan that is shown first.
        camera: first view of the browsers, as for `sim.rendering.cameras.Camera`.
    """

    problem: Problem
    scene: Scene
    plans: Sequence[Plan]
    start: Callable[[int], Begin]
    title: str
    chosen: int = 0
    camera: str = "fixed"


class Session:
    """One page: one plan, or two in step, and the user's commands.

    Attributes:
        show: what the page shows.
        playback: the playhead.
        shown: indices of the plans that are carried out, from left to right.
        stages: the scenes, from left to right; the second one is made when two plans are first shown.
    """

    def __init__(self, server: viser.ViserServer, show: Show) -> None:
        """Add the page to a server, and begin a plan."""
        self.playback = Playback()
        self.shown: tuple[int, ...] = ()
        self.show = show
        self._server = server
        self._viewpoint = Viewpoint.of(show.scene, show.camera)
        server.scene.set_up_direction("+z")
        self._viewpoint.take(server)
        dress(server, show.title)
        self.stages = [Stage(server, show.scene, partial(self._disturbed, 0))]
        self._panel = Panel(server, self)
        self._changing = threading.RLock()
        self._begin((show.chosen,), playing=False)
        self._opened = False
        server.on_client_connect(lambda client: self.open())

    def open(self) -> None:
        """Play when the page is opened for the first time."""
        if not self._opened:
            self._opened = True
            self.playback.play()

    def choose(self, index: int) -> None:
        """Carry out a plan of the front from the start; on the left, if there are two."""
        self._begin((index, *self.shown[1:]), playing=True)

    def beside(self, index: int | None) -> None:
        """Carry out the left plan and another one beside it, both from the start; None for the left one alone."""
        with self._changing:
            both = index is not None
            if both and len(self.stages) == 1:
                scene = self.show.scene
                right = Stage(self._server, scene, partial(self._disturbed, 1), root="/right", offset=beside(scene))
                self.stages.append(right)
            for stage in self.stages[1:]:
                stage.root.visible = both
            if both != (len(self.shown) == 2):
                (self._viewpoint.beside(self.stages[1].offset) if both else self._viewpoint).take(self._server)
            self._begin(self.shown[:1] if index is None else (self.shown[0], index), playing=True)

    def restart(self) -> None:
        """Carry out the same plans again from the start."""
        self._begin(self.shown, playing=self.playback.playing)

    def inject(self, kind: str, argument: str = "") -> None:
        """Let a fault happen now in every run, see `LiveRun.inject`."""
        self.playback.catch_up()
        for run in self.playback.runs:
            run.inject(kind, argument)

    def advance(self, seconds: float) -> None:
        """Advance by some real time, s, and show the new state.

        Raises:
            Exception: the error that ended a run.
        """
        with self._changing:
            for run in self.playback.runs:
                if run.failure is not None:
                    raise run.failure
            if all(run.frames for run in self.playback.runs):
                self.playback.advance(seconds)
                for stage, run in zip(self.stages, self.playback.runs, strict=False):
                    stage.show(run.frame_at(self.playback.time))
                    stage.show_pull()
                self._panel.update(self.shown)

    def close(self) -> None:
        """End the runs."""
        for run in self.playback.runs:
            run.stop()

    def _begin(self, indices: tuple[int, ...], *, playing: bool) -> None:
        with self._changing:
            for run in self.playback.runs:
                run.stop(wait=0)
            runs = [LiveRun(self.show.problem, self.show.start(index), until=0.0) for index in indices]
            self.playback.load(runs, playing=playing)
            self.shown = indices
            for run in runs:
                run.start()

    def _disturbed(self, side: int) -> LiveRun:
        """Return the run that the mouse disturbs on one side, and show its current state."""
        self.playback.catch_up()
        return self.playback.runs[side]


def beside(scene: Scene) -> tuple[float, float, float]:
    """Return the offset, m, that puts a scene to the right of another one, equally near to the camera `fixed`."""
    heading = np.radians(AZIMUTH_DEG)
    right = np.array([np.sin(heading), -np.cos(heading)])
    x, y = right * (2 * float(np.abs(scene.table.axes @ right) @ scene.table.half) + GAP_M)
    return float(x), float(y), 0.0


def watch(show: Show, *, port: int | None = None, ready: Callable[[str], None] = lambda address: None) -> None:
    """Carry plans out and show them in browsers, until Ctrl-C; `ready` gets the address once the server is up.

    The port is 0 for any free one, None for `DEFAULT_PORT` or the next free one.

    Raises:
        PrefplanError: the port is not free.
    """
    door, quiet = Door(), contextlib.redirect_stdout(io.StringIO())  # viser prints even if `verbose` is false
    with quiet:
        server = door.serve(DEFAULT_PORT if port is None else port)
    session = None
    try:
        # If a port is in use, viser uses the next one.
        if port and server.get_port() != port:
            raise PrefplanError(f"--port {port}: it is in use; --port 0 takes any free port")
        session = Session(server, show)
        ready(f"http://{HOST}:{server.get_port()}/{door.token}")
        before = time.monotonic()
        while True:
            now = time.monotonic()
            session.advance(now - before)
            before = now
            time.sleep(REFRESH_S)
    except KeyboardInterrupt:  # how the command ends, not an error
        pass
    finally:
        if session is not None:
            session.close()
        with quiet:
            server.stop()


def dress(server: viser.ViserServer, title: str) -> None:
    """Replace viser's title and icon."""
    icon = base64.b64encode(files(__package__).joinpath("icon.svg").read_bytes()).decode()
    link = json.dumps(f"data:image/svg+xml;base64,{icon}")
    source = f"document.title = {json.dumps(f'{title} - prefplan')};"
    source += f"document.querySelector('link[rel=icon]').href = {link};"
    # viser has no call for this; with this message it loads the scripts of its own figures.
    server.gui._websock_interface.queue_message(_messages.RunJavascriptMessage(source))
