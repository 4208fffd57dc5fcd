"""A server for browsers, and a run that plays on it."""

from __future__ import annotations

import contextlib
import io
import time
from collections.abc import Callable

import viser

from experiments.viewer.live_run import Begin, LiveRun
from experiments.viewer.panel import Panel
from experiments.viewer.playback import Playback
from experiments.viewer.stage import Stage
from prefplan.errors import PrefplanError
from prefplan.problem import Problem
from sim.world.scene import Scene

HOST = "127.0.0.1"
"""Other machines have no access."""

DEFAULT_PORT = 8080

REFRESH_S = 1 / 30
"""Time between two updates of the picture."""


def watch(
    problem: Problem,
    scene: Scene,
    begin: Begin,
    *,
    title: str,
    port: int | None = None,
    ready: Callable[[str], None] = lambda address: None,
) -> None:
    """Carry a plan out and play that in browsers, until Ctrl-C.

    Args:
        problem: what was planned.
        scene: what it is carried out in.
        begin: returns the pursuit of the plan at its start.
        title: what is carried out, for the panel.
        port: of the page, 0 for any free one; None for `DEFAULT_PORT` or the next free one.
        ready: called with the address as soon as browsers find it.

    Raises:
        PrefplanError: the port is not free.
    """
    with _quiet():
        server = viser.ViserServer(HOST, DEFAULT_PORT if port is None else port, verbose=False)
    run = LiveRun(problem, begin)
    try:
        # Where a port is taken, viser uses the next one.
        if port and server.get_port() != port:
            raise PrefplanError(f"--port {port}: it is not free; --port 0 takes any free port")
        playback = Playback(run)
        stage, panel = Stage(server, scene), Panel(server, title, playback)
        run.start()
        ready(f"http://{HOST}:{server.get_port()}")
        before = time.monotonic()
        while run.failure is None:
            now = time.monotonic()
            if run.frames:
                playback.advance(now - before)
                stage.show(run.frame_at(playback.time))
                panel.update()
            before = now
            time.sleep(REFRESH_S)
        raise run.failure
    except KeyboardInterrupt:
        # Ctrl-C is how the command ends, not an error.
        pass
    finally:
        run.stop()
        with _quiet():
            server.stop()


def _quiet() -> contextlib.redirect_stdout[io.StringIO]:
    """Return a context in which nothing is printed: viser prints at its start and end even if `verbose` is false."""
    return contextlib.redirect_stdout(io.StringIO())
