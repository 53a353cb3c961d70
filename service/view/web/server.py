"""The web server of the viewer: viser behind a guard, on loopback only."""

from __future__ import annotations

import asyncio
import contextlib
import io
import logging
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import viser
import websockets.asyncio.server

from tauten.service.link import HOST
from tauten.service.view.web.colours import Colours, set_theme
from tauten.service.view.web.guard import ORIGINS, Guard, Handler
from tauten.service.view.web.messages import LARGEST_FRAME
from tauten.service.view.web.policy import with_policy

FIRST_PORT = 8080
_CLOSE = 1.0  # s for which a browser may take to say goodbye


class ViewError(OSError):
    """A viewer that cannot be opened; the text names what to change."""


class LoopbackServer(viser.ViserServer):
    """viser's server without its public tunnel.

    Attributes:
        colours: of its pages.
    """

    colours: Colours

    def request_share_url(self, verbose: bool = True) -> None:
        """Refuse: a tunnel would let anybody drive the robot."""

    @property
    def onlookers(self) -> dict[int, viser.ClientHandle]:
        """The browsers that look on while another one operates, by their numbers."""
        # connections of the guard, which knows who operates
        live: dict[int, Any] = dict(self._websock_server._live_connections)
        return {
            number: client
            for number, client in self.get_clients().items()
            if number in live and not live[number].operates
        }

    def takes(self, identifier: str, value: object) -> bool:
        """Whether an input of the panel, by its identifier, may get a value from a browser.

        It is of the type of the present one; an input that is not there gets nothing.
        """
        handle = self.gui._gui_input_handle_from_uuid.get(identifier)
        return handle is None or _alike(value, handle._impl.value)


def _alike(value: object, present: object) -> bool:
    if isinstance(present, bool) or isinstance(value, bool):
        return isinstance(present, bool) and isinstance(value, bool)
    if isinstance(present, int | float):
        return isinstance(value, int | float)
    if isinstance(present, list | tuple):
        if not isinstance(value, list | tuple) or len(value) != len(present):
            return False
        return all(map(_alike, value, present))
    return isinstance(value, type(present))


class LoopEvent(asyncio.Event):
    """An event that is set in a running loop only.

    viser 1.1 sets the event of its messages in the thread that sends one, and once more in its loop. In other
    threads `asyncio.Event.set` may raise `RuntimeError: deque mutated during iteration`.
    """

    def set(self) -> None:
        """Set it and wake who waits; nothing in a thread without a running loop."""
        try:
            asyncio.get_running_loop()
        except RuntimeError:
            return
        super().set()


def _is_of_the_viewer(record: logging.LogRecord) -> bool:
    """False for requests that are no handshake of a browser, which anybody may send to a port.

    viser has such a filter, but adds it with the first request that it understands.
    """
    return record.getMessage() not in ("opening handshake failed", "connection rejected (200 OK)")


@contextmanager
def open_server(port: int, label: str) -> Iterator[tuple[LoopbackServer, Guard]]:
    """A server on loopback that accepts browsers of this computer, or at the end of a tunnel; port 0: any.

    Raises:
        ViewError: the port is taken.
    """
    listening = _listening(port)
    guard, colours = Guard(), Colours()
    logging.getLogger("websockets.server").addFilter(_is_of_the_viewer)
    serve = websockets.asyncio.server.serve

    def guarded(handler: Handler, _host: str, _port: int, **settings: Any) -> Any:
        settings |= {
            "process_request": with_policy(colours.answering(settings["process_request"]), ORIGINS),
            "sock": listening,
            "origins": [ORIGINS],
            "max_size": LARGEST_FRAME,
            "ping_interval": None,  # the guard pings
            "close_timeout": _CLOSE,
        }
        return serve(guard.wrapped(handler), **settings)

    # viser has no parameters for these: its thread looks `serve` up while the server is made
    websockets.asyncio.server.serve = guarded  # type: ignore[assignment,misc]
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            server = LoopbackServer(HOST, listening.getsockname()[1], label=label, verbose=False)
    finally:
        websockets.asyncio.server.serve = serve  # type: ignore[misc]
    server.colours = colours
    guard.takes = server.takes
    messages = server._websock_server._broadcast_buffer
    before, messages.message_event = messages.message_event, LoopEvent()
    messages.event_loop.call_soon_threadsafe(before.set)  # who waits for it already
    try:
        set_theme(server.gui, dark=False)
        server.on_client_connect(colours.ask)
        server.on_client_disconnect(colours.forget)
        yield server, guard
    finally:
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()
        listening.close()


def check_port(port: int) -> None:
    """Refuse a port of the page that is taken; 0 is any free one.

    Raises:
        ViewError: the port is taken.
    """
    _listening(port).close()


def _listening(port: int) -> socket.socket:
    """A socket bound to the port."""
    found = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        found.bind((HOST, port))
    except OSError as error:
        found.close()
        raise ViewError(
            f"port {port} on {HOST} is taken ({error.strerror}): is another viewer open? close it or give "
            "--web-port"
        ) from error
    return found
