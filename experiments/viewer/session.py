"""A server for browsers, and one performance after the other on its stage."""

from __future__ import annotations

import contextlib
import errno
import io
import socket
import threading
import time
from collections.abc import Callable

import viser

from experiments.viewer.panel import Panel
from experiments.viewer.performance import Begin, LiveRun
from experiments.viewer.stage import Stage
from prefplan.errors import PrefplanError
from prefplan.problem import Problem
from sim.world.scene import Scene

HOST = "127.0.0.1"
"""Nobody else's machine can look, or click."""

USUAL_PORT = 8080

REFRESH = 1 / 30
"""Time between two pictures, s; the browser draws no more than it gets."""


def watch(
    problem: Problem,
    scene: Scene,
    begin: Begin,
    *,
    title: str,
    port: int | None = None,
    ready: Callable[[str], None] = lambda address: None,
) -> None:
    """Show a plan's execution until Ctrl-C.

    Args:
        problem: what was planned.
        scene: what it is carried out in.
        begin: returns the pursuit of the plan at its start, once for every performance.
        title: what is carried out, for the panel.
        port: where browsers find it, 0 for any that is free; None for `USUAL_PORT` or the next that is free.
        ready: called with the address as soon as browsers find it.

    Raises:
        PrefplanError: the port cannot be had.
    """
    if port:
        _check_port(port)
    with _quiet():
        server = viser.ViserServer(HOST, USUAL_PORT if port is None else port, verbose=False)
    restart = threading.Event()
    performance = None
    try:
        stage, panel = Stage(server, scene), Panel(server, title, restart=restart.set)
        restart.set()
        ready(f"http://{HOST}:{server.get_port()}")
        while True:
            if restart.is_set():
                restart.clear()
                if performance is not None:
                    performance.stop()
                performance = LiveRun(problem, begin, speed=panel.speed)
                panel.control(performance)
                performance.start()
            assert performance is not None
            if performance.failure is not None:
                raise performance.failure
            if performance.moment is not None:
                stage.show(performance.moment)
                panel.show(performance.moment)
            time.sleep(REFRESH)
    except KeyboardInterrupt:
        # There is no other way to end it, so nothing is wrong.
        pass
    finally:
        if performance is not None:
            performance.stop()
        with _quiet():
            server.stop()


def _quiet() -> contextlib.redirect_stdout[io.StringIO]:
    """Return a context in which nothing is printed: viser greets and takes leave, whatever it is told."""
    return contextlib.redirect_stdout(io.StringIO())


def _check_port(port: int) -> None:
    """See whether a port is free: viser would quietly take another.

    Raises:
        PrefplanError: it is not.
    """
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                why = "it is taken by another program"
            else:
                why = (error.strerror or "it cannot be had").lower()
            raise PrefplanError(f"--port {port}: {why}; --port 0 takes any that is free") from None
