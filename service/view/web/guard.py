"""What a browser may send: known messages of bounded size with finite numbers, by one operator at a time.

viser 1.1 accepts WebSockets of any origin, checks limits in the browser alone, and lets any client open a
public tunnel. So this guard stands in front of it: it wraps the handler of the connections and passes to
viser only what it has checked.

| refused | because |
|---|---|
| a connection of another origin, or of none | a page of somebody else in the operator's browser |
| messages of other types | tunnels (`ShareUrlRequest`), commands: the viewer uses none of them |
| other fields than viser's, or of other types | viser would end the connection |
| more than 16 kB, nested values, numbers that are not finite or beyond 1e6 | no correct message is so |
| a picture that was not asked for, or of another size | only *PNG* needs one |
| a file of more than 48 kB, or for an input that takes none | lists of waypoints are no larger |
| input of a further browser, except to stop and to hold | it looks on: the one connected longest operates |

What is larger than its sender may send now is refused before it is decoded: more than 16 kB only from the
browser that operates, while a picture or a file is expected of it.
"""

from __future__ import annotations

import asyncio
import logging
import re
from collections import Counter
from collections.abc import Callable, Coroutine, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from tauten.service.view.web.messages import (
    CAMERA,
    FILE,
    LARGEST_FILE,
    LARGEST_FRAME,
    LARGEST_MESSAGE,
    PART,
    PICTURE,
    decoded,
    message_type,
    picture_size,
    problem,
)

log = logging.getLogger(__name__)

ORIGINS = re.compile(r"http://(localhost|127\.0\.0\.1|\[::1\])(:\d{1,5})?")
_MOST_FILES = 1000  # of one viewer
# A browser that does not answer a ping for 1.5 s has left: the robot no longer follows it. Its connection
# lasts longer, because a slow link delays answers, too, while the scene is loaded. The time is counted in
# slices, so that a pause of this process is none of the browser.
_PING_INTERVAL, _SLICE = 0.4, 0.1  # s
_SILENT, _GONE = 15, 100  # slices

Handler = Callable[[ServerConnection], Coroutine[Any, Any, None]]


class Guard:
    """Checks the messages of all browsers.

    Attributes:
        refused: number of refused messages by reason.
        for_all: values that browsers that look on may give inputs of the panel, by identifiers of these.
        takes: whether an input of the panel, by its identifier, may get a value.
        uploads: inputs that the browser that operates may send files to.
        operator_left: called, in the server's thread, when the browser that operates has left: its connection
            has ended, or it has not answered a ping for 1.5 s.
    """

    def __init__(self) -> None:
        self.refused: Counter[str] = Counter()
        self._connections: list[ServerConnection] = []
        self.operator_left: Callable[[], None] = lambda: None
        self.for_all: Mapping[str, frozenset[bool | str]] = {}
        self.takes: Callable[[str, object], bool] = lambda identifier, value: True
        self.uploads: frozenset[str] = frozenset()
        self._files = 0
        self._file_from: ServerConnection | None = None  # that has announced one
        self._picture: tuple[ServerConnection, tuple[int, int]] | None = None  # that is expected

    @contextmanager
    def picture(self, height: int, width: int) -> Iterator[None]:
        """Let one picture of the browser that operates through while the block runs: it is asked for."""
        sender = next(iter(self._connections), None)
        self._picture = None if sender is None else (sender, (height, width))
        try:
            yield
        finally:
            self._picture = None

    @property
    def browsers(self) -> int:
        """Number of connected browsers."""
        return len(self._connections)

    def wrapped(self, handler: Handler) -> Handler:
        """A handler of connections that sees only what this guard passes."""

        async def guarded(connection: ServerConnection) -> None:
            self._connections.append(connection)
            watch = asyncio.create_task(self._watch(connection))
            try:
                # a proxy with another `recv`; viser uses the connection's methods and nothing of its type
                await handler(_Checked(connection, self))  # type: ignore[arg-type]
            finally:
                watch.cancel()
                operated = self.operates(connection)
                self._connections.remove(connection)
                if operated:
                    self.operator_left()

        return guarded

    async def _watch(self, connection: ServerConnection) -> None:
        """Ping a browser until it has left: `operator_left` does not wait for its connection to end."""
        while True:
            answer = asyncio.create_task(_answers(connection))
            try:
                await self._await(answer, connection)
            finally:
                there = answer.done() and answer.result()
                answer.cancel()
            if not there:
                connection.transport.abort()
                return
            await asyncio.sleep(_PING_INTERVAL)

    async def _await(self, answer: asyncio.Task[bool], connection: ServerConnection) -> None:
        """Wait for an answer to a ping while the browser may be there."""
        silent = 0
        while not answer.done() and silent < _GONE:
            await asyncio.wait({answer}, timeout=_SLICE)
            silent += 1
            if silent == _SILENT and not answer.done() and self.operates(connection):
                log.warning("the browser that operates does not answer")
                self.operator_left()

    def passes(self, connection: ServerConnection, raw: object) -> bool:
        """Whether a message of a connection is correct and its sender may send it."""
        reason = self._refusal(connection, raw)
        if reason is None:
            return True
        self.refused[reason] += 1
        if self.refused[reason] == 1:
            log.warning("a browser's message was refused: %s", reason)
        return False

    def operates(self, connection: ServerConnection) -> bool:
        """Whether a browser operates: it has been connected longest."""
        return bool(self._connections) and self._connections[0] is connection

    def _refusal(self, connection: ServerConnection, raw: object) -> str | None:
        """Why a message is refused; None where it passes."""
        if not isinstance(raw, bytes):
            return "text instead of bytes"
        if len(raw) > self._largest(connection):
            return "too large"
        content = decoded(raw)
        if (reason := problem(raw, content)) is not None:
            return reason
        if not self.operates(connection) and not self._is_for_all(content):
            return "not the operator"
        return None if self._fits(connection, content) else "wrong value"

    def _largest(self, connection: ServerConnection) -> int:
        """Bytes that a browser's next message may have."""
        if not self.operates(connection):
            return LARGEST_MESSAGE
        if self._expected(connection) is not None:
            return LARGEST_FRAME
        return LARGEST_MESSAGE + LARGEST_FILE * (self._file_from is connection)

    def _expected(self, connection: ServerConnection) -> tuple[int, int] | None:
        """Height and width of the picture that is expected of a browser; None: none is."""
        expected = self._picture  # once: another thread sets it
        return expected[1] if expected is not None and expected[0] is connection else None

    def _fits(self, connection: ServerConnection, content: dict[str, Any]) -> bool:
        """Whether a correct message gives an input of the panel what it may get; other messages do."""
        kind = message_type(content)
        if kind == PICTURE:
            expected, payload = self._expected(connection), content["payload"]
            self._picture = None
            # an empty one says that the browser could not make it
            return expected is not None and (not payload or picture_size(payload) == expected)
        if kind in (FILE, PART):
            self._files += kind == FILE
            fits = self._files <= _MOST_FILES and content["source_component_uuid"] in self.uploads
            self._file_from = connection if fits and kind == FILE else None
            return fits
        if kind != "GuiUpdateMessage":
            return True
        return all(self.takes(content["uuid"], value) for value in content["updates"].values())

    def _is_for_all(self, content: dict[str, Any]) -> bool:
        """Whether a correct message may come from a browser that looks on."""
        if (kind := message_type(content)) != "GuiUpdateMessage":
            return kind == CAMERA
        allowed = self.for_all.get(content["uuid"], frozenset())
        value = content["updates"].get("value")
        return isinstance(value, bool | str) and value in allowed


async def _answers(connection: ServerConnection) -> bool:
    """Whether a browser answers a ping; False once its connection has ended."""
    with suppress(ConnectionClosed):
        await (await connection.ping())  # both take their time where a link does not take data
        return True
    return False


class _Checked:
    """A connection whose `recv` passes over messages that the guard refuses."""

    def __init__(self, connection: ServerConnection, guard: Guard) -> None:
        self._connection = connection
        self._guard = guard

    def __getattr__(self, name: str) -> Any:
        return getattr(self._connection, name)

    @property
    def operates(self) -> bool:
        """Whether the browser operates, rather than looks on."""
        return self._guard.operates(self._connection)

    async def recv(self) -> bytes:
        """The next message that passes."""
        while True:
            raw = await self._connection.recv()
            if self._guard.passes(self._connection, raw) and isinstance(raw, bytes):
                return raw
