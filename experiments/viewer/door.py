"""The door of the viewer: who may connect, and which messages and values are accepted.

viser serves pages of every origin, and acts on every message of its protocol. Here, a request needs a random token,
which only the user who started the viewer knows, and the page's own host and origin. Messages that the page does not
send, and values that its controls do not have, are refused.
"""

import http
import secrets
import warnings
from collections.abc import Awaitable, Callable, Iterable
from dataclasses import fields, replace
from typing import Any, get_type_hints

import msgspec
import viser
import websockets.asyncio.server
from viser import _messages
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from experiments.cli.status import tell

HOST = "127.0.0.1"
"""Only this machine has access."""

NAMES = (HOST, "localhost")
"""Names of this machine that an address may have; others may be an attacker's (DNS rebinding)."""

TOKEN_BYTES = 32

FARTHEST = 1e4
"""Greatest absolute number in a message, e.g. about a place or a direction, m or pixels."""

USED = (
    _messages.GuiUpdateMessage,
    _messages.SceneNodeClickMessage,
    _messages.SceneNodeDragMessage,
    _messages.ViewerCameraMessage,
)
"""The messages that the page sends; viser's others upload files, or publish the page through another server."""

FIELDS = {message: {one.name: get_type_hints(message)[one.name] for one in fields(message)} for message in USED}
"""The types of their fields, by name."""

SAFE_HEADERS = {"Referrer-Policy": "no-referrer", "Content-Security-Policy": "frame-ancestors 'none'"}
"""Headers that hide the address, with its token, from other pages, and forbid them to show this one in a frame."""


class Door:
    """Accepts only requests with its token.

    Attributes:
        token: the first part of the path of every valid request.
    """

    def __init__(self) -> None:
        """Draw a token."""
        self.token = secrets.token_urlsafe(TOKEN_BYTES)
        self._server: viser.ViserServer | None = None

    def serve(self, port: int) -> viser.ViserServer:
        """Return a new server behind this door; if the port is in use, viser takes the next one."""
        # viser has no parameter for such checks, but looks up this function when its server starts.
        module = websockets.asyncio.server
        before: Any = module.serve

        def serve(
            handler: Callable[[Any], Any],
            *where: Any,
            process_request: Callable[[Any, Request], Response | None],
            **options: Any,
        ) -> Any:
            async def guarded(connection: Any) -> None:
                connection.recv = self._receiver(connection.recv)
                await handler(connection)

            def checked(connection: Any, request: Request) -> Response | None:
                port = connection.local_address[1]
                path = self.path(request, port)
                if path is None:
                    return Response(
                        http.HTTPStatus.FORBIDDEN, "Forbidden", Headers(), b"the address has no valid token\n"
                    )
                response = process_request(connection, replace(request, path=path))
                if response is not None:
                    response.headers.update(SAFE_HEADERS)
                return response

            return before(guarded, *where, process_request=checked, **options)

        module.serve = serve  # type: ignore[misc, assignment]
        try:
            self._server = viser.ViserServer(HOST, port, verbose=False)
        finally:
            module.serve = before  # type: ignore[misc]
        return self._server

    def path(self, request: Request, port: int) -> str | None:
        """Return the path after the token in a request to a port, or None if the request is refused."""
        _, given, *rest = [*request.path.partition("?")[0].split("/"), "", ""]
        hosts, origins = (request.headers.get_all(name) for name in ("Host", "Origin"))
        own = [f"{name}:{port}" for name in NAMES]
        is_socket = request.headers.get("Upgrade", "").lower() == "websocket"
        if not secrets.compare_digest(given.encode(), self.token.encode()):
            return None
        if len(hosts) != 1 or hosts[0] not in own:
            return None
        if origins != [f"http://{hosts[0]}"] and (origins or is_socket):
            return None
        return "/" + "/".join(rest).strip("/")

    def _receiver(self, receive: Callable[[], Awaitable[Any]]) -> Callable[[], Awaitable[Any]]:
        """Return a function that receives the next valid message of a connection, as bytes."""

        async def receive_valid() -> Any:
            while True:
                received = await receive()
                objection = _objection(self._server, received)
                if objection is None:
                    return received
                tell(f"refused from the browser: {objection}")

        return receive_valid


def _objection(server: viser.ViserServer | None, received: Any) -> str | None:
    """Return what is wrong with a received message, or None."""
    try:
        with warnings.catch_warnings(action="ignore"):  # of what is refused below
            message = _messages.Message.deserialize(received)
    except Exception as error:  # whatever a decoder of foreign bytes may raise
        return f"no message ({type(error).__name__})"
    if not isinstance(message, USED):
        return f"a message of another kind, {type(message).__name__}"
    for field, kind in FIELDS[type(message)].items():
        value = getattr(message, field)
        try:
            is_valid = all(abs(number) <= FARTHEST for number in _numbers(msgspec.convert(value, kind)))
        except msgspec.ValidationError:
            is_valid = False
        if not is_valid:
            return f"{field} is {value!r}"
    if server is None:
        return "it came too early"
    if isinstance(message, _messages.GuiUpdateMessage):
        return _objection_to_update(server.gui._gui_input_handle_from_uuid.get(message.uuid), message.updates)
    name: Any = getattr(message, "name", None)
    index = getattr(message, "instance_index", None)
    node = server.scene._handle_from_node_name.get(name)
    if name is not None and node is None:
        return f"there is no object {name!r}"
    if index is not None and not (type(index) is int and 0 <= index < len(getattr(node, "batched_positions", (0,)))):
        return f"there is no instance {index!r} of {name!r}"
    return None


def _objection_to_update(handle: Any, updates: Any) -> str | None:
    """Return what is wrong with a new value of a control, or None."""
    if handle is None:
        return "there is no such control"
    value = updates.get("value") if isinstance(updates, dict) and [*updates] == ["value"] else None
    if hasattr(handle, "options"):
        valid = value in handle.options
    elif hasattr(handle, "max"):
        valid = type(value) in (int, float) and handle.min <= value <= handle.max
    else:
        valid = type(value) is bool
    return None if valid else f"{handle.label or 'a control'} has no value {value!r}"


def _numbers(value: Any) -> Iterable[Any]:
    if isinstance(value, (tuple, list)):
        for part in value:
            yield from _numbers(part)
    elif isinstance(value, (int, float)):
        yield value
