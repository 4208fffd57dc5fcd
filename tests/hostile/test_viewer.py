"""The viewer belongs to one person: strangers are not let in, and what a browser sends is checked like a scenario."""

from __future__ import annotations

import http.client
import http.server
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import msgspec
import pytest
import viser
import zstandard
from report_browser import start_chrome
from scenario_texts import CUP
from selenium.webdriver.support.ui import WebDriverWait
from viser import _messages
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

PROGRAM = [sys.executable, "-c", "import sys; from experiments.commands.command_line import main; sys.exit(main())"]

TIMEOUT_S = 120.0

PROTOCOL = [f"viser-v{viser.__version__}"]


class Viewer:
    """A running viewer: where it is, and what it prints to stderr."""

    def __init__(self, folder: Path) -> None:
        (folder / "cup.toml").write_text(CUP)
        self.errors = folder / "errors"
        with self.errors.open("w") as errors:
            command = [*PROGRAM, "-q", "view", str(folder / "cup.toml"), "--port", "0", "--no-open"]
            self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True)
        assert self.process.stdout is not None
        found = re.search(r"http://127\.0\.0\.1:(\d+)/?(\S*)", self.process.stdout.readline())
        assert found
        self.port, self.token = int(found[1]), found[2]

    @property
    def host(self) -> str:
        return f"127.0.0.1:{self.port}"

    def status(self, path: str, *more: tuple[str, str], **headers: str) -> int:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=TIMEOUT_S)
        connection.putrequest("GET", path, skip_host=True)
        for name, value in (*({"Host": self.host} | headers).items(), *more):
            connection.putheader(name, value)
        connection.endheaders()
        return connection.getresponse().status

    def socket(self, token: str, *, origin: str | None, host: str | None = None) -> ClientConnection:
        address = f"ws://{host or self.host}/{token}"
        return connect(
            address,
            sock=None if host is None else __import__("socket").create_connection(("127.0.0.1", self.port)),
            origin=origin,  # type: ignore[arg-type]
            subprotocols=PROTOCOL,  # type: ignore[arg-type]
            max_size=None,
        )


@pytest.fixture(scope="module")
def viewer(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Viewer]:
    viewer = Viewer(tmp_path_factory.mktemp("viewer"))
    yield viewer
    viewer.process.kill()
    viewer.process.communicate()


def test_a_page_is_served_to_who_has_the_token_only(viewer: Viewer) -> None:
    assert viewer.status(f"/{viewer.token}") == 200 and len(viewer.token) == 43
    for path in ("/", "/index.html", f"/{viewer.token[:-1]}", f"/x{viewer.token}", f"/?token={viewer.token}"):
        assert viewer.status(path) == 403
    assert viewer.status(f"/{viewer.token}/../../pyproject.toml") == 404


def test_another_host_or_origin_is_refused(viewer: Viewer) -> None:
    path = f"/{viewer.token}"
    assert viewer.status(path, Host=f"evil.example:{viewer.port}") == 403, "DNS rebinding"
    assert viewer.status(path, Host="127.0.0.1") == 403
    assert viewer.status(path, Origin="http://evil.example") == 403
    assert viewer.status(path, ("Host", f"evil.example:{viewer.port}")) == 403, "a second host"
    assert viewer.status(path, ("Origin", "http://evil.example"), Origin=f"http://{viewer.host}") == 403
    assert viewer.status(path, Host=f"localhost:{viewer.port}") == 200
    assert viewer.status(path, Origin=f"http://{viewer.host}") == 200


def test_a_socket_needs_token_origin_and_host(viewer: Viewer) -> None:
    own = f"http://{viewer.host}"
    for token, origin, host in (
        ("", own, None),
        ("wrong", own, None),
        (viewer.token, None, None),
        (viewer.token, "http://evil.example", None),
        (viewer.token, "null", None),
        (viewer.token, f"http://127.0.0.1:{viewer.port + 1}", None),
        (viewer.token, f"http://evil.example:{viewer.port}", f"evil.example:{viewer.port}"),
    ):
        with pytest.raises(InvalidStatus, match="403"):
            viewer.socket(token, origin=origin, host=host)
    viewer.socket(viewer.token, origin=own).close()


class Browser:
    """A client that has the token, and sends what it likes."""

    def __init__(self, viewer: Viewer) -> None:
        self.socket = viewer.socket(viewer.token, origin=f"http://{viewer.host}")
        self.controls: dict[str, dict[str, Any]] = {}
        self.nodes: list[str] = []
        self._read()

    def _read(self) -> None:
        """Read the page's controls and the scene's nodes."""
        with suppress(TimeoutError):
            while True:
                received = self.socket.recv(timeout=3.0)
                assert isinstance(received, bytes)
                length = int.from_bytes(received[8:16], "little")
                decoded = msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(received[16 : 16 + length]))
                for message in decoded["messages"]:
                    if "uuid" in message and "props" in message:
                        self.controls[message["props"].get("label", "")] = message
                    if str(message.get("name", "")).startswith("/left/bodies/cup/"):
                        self.nodes.append(message["name"])

    def send(self, message: _messages.Message, **forged: Any) -> None:
        self.socket.send(msgspec.msgpack.encode(message.as_serializable_dict([]) | forged))

    def set(self, label: str, value: Any) -> None:
        self.send(_messages.GuiUpdateMessage(self.controls[label]["uuid"], {"value": value}))


def camera(position: float = 1.0) -> _messages.ViewerCameraMessage:
    return _messages.ViewerCameraMessage(
        (1.0, 0.0, 0.0, 0.0), (position, 1.0, 1.0), 1.0, 0.01, 1000.0, 600, 800, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    )


def drag(name: str, phase: Any, end: float, index: Any = None) -> _messages.SceneNodeDragMessage:
    return _messages.SceneNodeDragMessage(
        phase, name, index, (0.5, 0.1, 0.0), (0.5, 0.5), (end, end, end), (0.5, 0.5), "left", None
    )


def test_bad_values_from_a_browser_are_refused_and_end_nothing(viewer: Viewer) -> None:
    browser = Browser(viewer)
    assert browser.nodes and {"Object", "Speed", "Time"} <= set(browser.controls)
    browser.send(camera())
    bad = [
        lambda: browser.set("Object", "teapot"),
        lambda: browser.set("Speed", "1e9"),
        lambda: browser.set("Speed", 1e9),
        lambda: browser.set("Time", float("nan")),
        lambda: browser.set("Time", 1e9),
        lambda: browser.set("Time", "late"),
        lambda: browser.set("Beside it", "99: no plan"),
        lambda: browser.set("It", "Teleport"),
        lambda: browser.send(_messages.GuiUpdateMessage("no-such-control", {"value": True})),
        lambda: browser.send(_messages.GuiUpdateMessage(browser.controls["Speed"]["uuid"], {"removed": True})),
        lambda: browser.send(drag(browser.nodes[0], "start", float("nan"))),
        lambda: browser.send(drag(browser.nodes[0], "start", float("inf"))),
        lambda: browser.send(drag(browser.nodes[0], "start", 1e9)),
        lambda: browser.send(drag(browser.nodes[0], "start", 0.5, 10**6)),
        lambda: browser.send(drag("/left/bodies/teapot/0", "start", 0.5)),
        lambda: browser.send(drag(browser.nodes[0], "start", 0.5), end_position=[[1, 2, 3], [4, 5, 6]]),
        lambda: browser.send(drag(browser.nodes[0], "start", 0.5), end_position=[0.5]),
        lambda: browser.send(drag(browser.nodes[0], "start", 0.5), name=[browser.nodes[0]]),
        lambda: browser.send(drag(browser.nodes[0], "start", 0.5), phase="fly"),
        lambda: browser.send(camera(), position=[[1, 2], 3, 4]),
        lambda: browser.send(camera(float("nan"))),
        lambda: browser.send(_messages.GuiUpdateMessage("any", {"value": True}), uuid={"a": 1}),
        lambda: browser.send(_messages.ShareUrlRequest()),
        lambda: browser.socket.send(b"\xc1"),
        lambda: browser.socket.send(msgspec.msgpack.encode({"type": "NoSuchMessage"})),
        lambda: browser.socket.send("text"),
    ]
    for send in bad:
        send()
    browser.set("Speed", "8")
    with suppress(TimeoutError, ConnectionClosed):
        browser.socket.recv(timeout=2.0)
    browser.socket.close()
    told = viewer.errors.read_text()
    assert viewer.process.poll() is None and "Traceback" not in told
    assert told.count("refused from the browser: ") == len(bad), told
    assert "a message of another kind, ShareUrlRequest" in told
    assert viewer.status(f"/{viewer.token}") == 200


def test_a_page_of_another_origin_neither_reads_nor_connects(
    viewer: Viewer, chromium: tuple[str, str], tmp_path: Path
) -> None:
    """It knows the port, but not the token; with a token it would still be of another origin."""
    (tmp_path / "index.html").write_text(
        f"""<script>
        const found = [];
        const attempt = (path) => new Promise((resolve) => {{
          const socket = new WebSocket("ws://{viewer.host}/" + path, ["{PROTOCOL[0]}"]);
          socket.onopen = () => resolve("open");
          socket.onerror = () => resolve("refused");
        }});
        const frame = (path) => fetch("http://{viewer.host}/" + path).then((r) => "read", () => "refused");
        Promise.all(["", "{viewer.token}"].flatMap((path) => [attempt(path), frame(path)]))
          .then((all) => document.title = all.join(" "));
        </script>"""
    )

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *words: Any) -> None:
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), lambda *given: Quiet(*given, directory=str(tmp_path)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    chrome = start_chrome(chromium)
    try:
        chrome.get(f"http://127.0.0.1:{server.server_address[1]}/")
        WebDriverWait(chrome, TIMEOUT_S).until(lambda _: chrome.title)
        assert chrome.title == "refused refused refused refused"
    finally:
        chrome.quit()
        server.shutdown()


def test_ctrl_c_still_ends_it_quietly(viewer: Viewer) -> None:
    viewer.process.send_signal(signal.SIGINT)
    assert viewer.process.wait(TIMEOUT_S) == 0
    told = viewer.errors.read_text().splitlines()
    assert not [line for line in told if not line.startswith("prefplan: refused")]
