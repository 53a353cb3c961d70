"""A viewer of the small robot for tests, and clients that send it what a browser would, or an attacker."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin, Subprotocol

from tauten.service.frames import ServedRobot, SimulatedRobot
from tauten.service.process import StopFlag
from tauten.service.view import Guard, open_server
from tauten.service.view.session import ViewSession
from tauten.service.view.web.server import LoopbackServer

GIZMO = "/gizmos/tip"


@dataclass
class Shown:
    """A viewer that runs in a thread."""

    session: ViewSession
    server: LoopbackServer
    guard: Guard

    @property
    def origin(self) -> str:
        """Origin of the viewer's own page."""
        return f"http://127.0.0.1:{self.server.get_port()}"


@contextmanager
def showing(
    source: SimulatedRobot | ServedRobot, robot_file: Path | None = None, lit: bool = False
) -> Iterator[Shown]:
    """Show a robot until the block ends.

    Args:
        source: of the frames.
        robot_file: that cables are drawn into.
        lit: whether surroundings light the robot, as they do for a user. They take a browser without a
            graphics card eight seconds.
    """
    stop = StopFlag()
    with open_server(0, "test") as (server, guard):
        if not lit:
            server.scene.configure_environment_map(None)
            server.scene.configure_default_lights(cast_shadow=False)
        session = ViewSession(source, server, guard, robot_file)
        thread = threading.Thread(target=session.run, args=(stop,))
        thread.start()
        try:
            yield Shown(session, server, guard)
        finally:
            stop.request()
            thread.join()


@contextmanager
def browser(shown: Shown, origin: str | None = "own") -> Iterator[ClientConnection]:
    """A client as viser's page is one; reads what it gets, so that the server is not held up.

    Args:
        shown: the viewer.
        origin: header; "own": that of the viewer's page; None: no header.
    """
    header = shown.origin if origin == "own" else origin
    with connect(
        f"ws://127.0.0.1:{shown.server.get_port()}",
        origin=None if header is None else Origin(header),
        subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
        compression=None,
        max_size=None,
    ) as connection:
        reader = threading.Thread(target=_drain, args=(connection,), daemon=True)
        reader.start()
        send(connection, "ViewerCameraMessage", **CAMERA)
        yield connection


CAMERA: dict[str, Any] = {
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (0.0, 0.0, 0.0),
    "fov": 1.0,
    "near": 0.01,
    "far": 10.0,
    "image_height": 100,
    "image_width": 100,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}


def send(connection: ClientConnection, kind: str, **fields: object) -> None:
    """Send a message of viser."""
    connection.send(msgspec.msgpack.encode({"type": kind, **fields}))


def drag(connection: ClientConnection, position: tuple[float, ...], name: str = GIZMO) -> None:
    """Send what dragging a gizmo sends."""
    send(
        connection, "TransformControlsUpdateMessage", name=name, wxyz=(1.0, 0.0, 0.0, 0.0),
        position=position, owner="",
    )  # fmt: skip


def wait_until(done: Callable[[], bool], seconds: float = 30.0) -> bool:
    """Whether something becomes true in time."""
    end = time.monotonic() + seconds
    while not done():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


def _drain(connection: ClientConnection) -> None:
    with suppress(ConnectionClosed):
        for _ in connection:
            pass
