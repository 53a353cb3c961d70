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
| a picture that was not asked for | only *PNG* needs one |
| a file of more than 48 kB, or for an input that takes none | lists of waypoints are no larger |
| input of a further browser, except to stop and to hold | it looks on: the one connected longest operates |
"""

from __future__ import annotations

import asyncio
import logging
import math
import re
from collections import Counter
from collections.abc import Callable, Coroutine, Mapping
from contextlib import suppress
from typing import Any

import msgspec
from viser._messages import Message
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

log = logging.getLogger(__name__)

ORIGINS = re.compile(r"http://(localhost|127\.0\.0\.1|\[::1\])(:\d{1,5})?")
LARGEST_MESSAGE = 16_384  # bytes; the largest correct one has a few hundred
LARGEST_FILE = 49_152  # bytes
LARGEST_NUMBER = 1e6
_MOST_FILES = 1000  # of one viewer
LARGEST_PICTURE = 2**23  # bytes
LARGEST_FRAME = LARGEST_PICTURE + LARGEST_MESSAGE  # bytes; a larger one ends its connection
_PICTURE = "GetRenderResponseMessage"
# A browser that does not answer a ping for 1.5 s has left: the robot no longer follows it. Its connection
# lasts longer, because a slow link delays answers, too, while the scene is loaded. The time is counted in
# slices, so that a pause of this process is none of the browser.
_PING_INTERVAL, _SLICE = 0.4, 0.1  # s
_SILENT, _GONE = 15, 100  # slices

_CAMERA = "ViewerCameraMessage"
_MOST_TEXT = 200  # characters
_MOST_VALUES = 32  # of a list or mapping
_DEPTH = 4

Handler = Callable[[ServerConnection], Coroutine[Any, Any, None]]


class Guard:
    """Checks the messages of all browsers.

    Attributes:
        refused: number of refused messages by reason.
    """

    def __init__(self) -> None:
        """Start without a browser."""
        self.refused: Counter[str] = Counter()
        self._connections: list[ServerConnection] = []
        self._leaving: list[Callable[[], None]] = []
        self._for_all: Mapping[str, frozenset[bool | str]] = {}
        self._takes: Callable[[str, object], bool] = lambda identifier, value: True
        self._uploads: frozenset[str] = frozenset()
        self._files = 0
        self._pictures = 0  # that were asked for

    def let_all(self, values: Mapping[str, frozenset[bool | str]]) -> None:
        """Let browsers that look on give inputs of the panel these values.

        Args:
            values: what is allowed, by the identifier of the input.
        """
        self._for_all = values

    def let_upload(self, identifiers: frozenset[str]) -> None:
        """Let the browser that operates send files to these inputs of the panel."""
        self._uploads = identifiers

    def expect_picture(self) -> None:
        """Let one more picture of the browser that operates through: it was asked for."""
        self._pictures += 1

    def check_inputs(self, takes: Callable[[str, object], bool]) -> None:
        """Let through only what inputs of the panel may get.

        Args:
            takes: whether an input, by its identifier, may get a value.
        """
        self._takes = takes

    @property
    def browsers(self) -> int:
        """Number of connected browsers."""
        return len(self._connections)

    def on_operator_left(self, callback: Callable[[], None]) -> None:
        """Call a function, in the server's thread, when the browser that operates has left.

        It has when its connection ends, and 1.5 s after a ping that it does not answer.
        """
        self._leaving.append(callback)

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
                    self._left()

        return guarded

    async def _watch(self, connection: ServerConnection) -> None:
        """Ping a browser until it has left: `on_operator_left` does not wait for its connection to end."""
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
                self._left()

    def _left(self) -> None:
        for callback in self._leaving:
            callback()

    def passes(self, connection: ServerConnection, raw: object) -> bool:
        """Whether a message of a connection is correct and its sender may send it.

        Args:
            connection: of the sender.
            raw: the message.
        """
        reason = problem(raw)
        if reason is None and not self.operates(connection) and not self._is_for_all(raw):
            reason = "not the operator"
        if reason is None and not self._fits(raw):
            reason = "wrong value"
        if reason is None:
            return True
        self.refused[reason] += 1
        if self.refused[reason] == 1:
            log.warning("a browser's message was refused: %s", reason)
        return False

    def operates(self, connection: ServerConnection) -> bool:
        """Whether a browser operates: it has been connected longest."""
        return bool(self._connections) and self._connections[0] is connection

    def _fits(self, raw: object) -> bool:
        """Whether a correct message gives an input of the panel what it may get; other messages do."""
        if message_type(raw) == _PICTURE:
            self._pictures, expected = max(self._pictures - 1, 0), self._pictures > 0
            return expected
        if message_type(raw) in _FILES and isinstance(raw, bytes):
            content = msgspec.msgpack.decode(raw)
            self._files += message_type(raw) == "FileTransferStartUpload"
            return self._files <= _MOST_FILES and content["source_component_uuid"] in self._uploads
        if message_type(raw) != "GuiUpdateMessage" or not isinstance(raw, bytes):
            return True
        content = msgspec.msgpack.decode(raw)
        return all(self._takes(content["uuid"], value) for value in content["updates"].values())

    def _is_for_all(self, raw: object) -> bool:
        """Whether a correct message may come from a browser that looks on."""
        kind = message_type(raw)
        if kind != "GuiUpdateMessage" or not isinstance(raw, bytes):
            return kind == _CAMERA
        content = msgspec.msgpack.decode(raw)
        allowed = self._for_all.get(content["uuid"], frozenset())
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


def message_type(raw: object) -> str:
    """Name of a message's type; "" of what is no message."""
    if not isinstance(raw, bytes):
        return ""
    try:
        content = msgspec.msgpack.decode(raw)
    except (msgspec.DecodeError, RecursionError, ValueError):
        return ""
    return str(content.get("type", "")) if isinstance(content, dict) else ""


def problem(raw: object) -> str | None:
    """Why a message is refused, whoever sends it; None where it is correct."""
    if not isinstance(raw, bytes):
        return "text instead of bytes"
    kind = message_type(raw)
    if len(raw) > LARGEST_MESSAGE and kind not in _CONTENTS:
        return "too large"
    if not kind:
        return "not a message of viser"
    if kind not in _SHAPES:
        return f"type {kind[:40]}"
    content = msgspec.msgpack.decode(raw)
    name, largest = _CONTENTS.get(kind, ("", 0))
    part = content.pop(name, b"")
    if not isinstance(part, bytes) or len(part) > largest or not is_bounded(content, _DEPTH):
        return "values out of bounds"
    return None if _SHAPES[kind](content) and _is_read(raw) else "wrong fields"


def _is_read(raw: bytes) -> bool:
    """Whether viser makes a message of it: where it cannot, it ends the connection."""
    try:
        Message.deserialize(raw)
    except Exception:  # whatever fields of other names and types raise
        return False
    return True


def is_bounded(value: object, depth: int) -> bool:
    """Whether a value is made of short texts, and of finite numbers that are not larger than 1e6.

    Args:
        value: decoded.
        depth: that lists and mappings may be nested.
    """
    if value is None or isinstance(value, bool):
        return True
    if isinstance(value, str):
        return len(value) <= _MOST_TEXT
    if isinstance(value, int | float):
        return math.isfinite(value) and abs(value) <= LARGEST_NUMBER
    if not isinstance(value, list | tuple | dict) or depth == 0 or len(value) > _MOST_VALUES:
        return False
    if isinstance(value, dict):
        return all(is_bounded(key, 0) for key in value) and all(
            is_bounded(one, depth - 1) for one in value.values()
        )
    return all(is_bounded(one, depth - 1) for one in value)


def _is_numbers(value: object, count: int) -> bool:
    return (
        isinstance(value, list | tuple)
        and len(value) == count
        and all(isinstance(one, int | float) and not isinstance(one, bool) for one in value)
    )


def _is_transform(content: dict[str, Any]) -> bool:
    return (
        isinstance(content.get("name"), str)
        and _is_numbers(content.get("position"), 3)
        and _is_numbers(content.get("wxyz"), 4)
    )


def _is_drag(content: dict[str, Any]) -> bool:
    return isinstance(content.get("name"), str)


def _is_receipt(content: dict[str, Any]) -> bool:
    """Of a part of a file that the browser was sent."""
    return isinstance(content.get("transfer_uuid"), str) and isinstance(
        content.get("source_component_uuid"), str | None
    )


def _is_file(content: dict[str, Any]) -> bool:
    """A file in one part."""
    return (
        isinstance(content.get("source_component_uuid"), str)
        and content.get("part_count") == 1
        and isinstance(size := content.get("size_bytes"), int)
        and 0 < size <= LARGEST_FILE
    )


def _is_part(content: dict[str, Any]) -> bool:
    return isinstance(content.get("source_component_uuid"), str) and content.get("part_index") == 0


def _is_update(content: dict[str, Any]) -> bool:
    """Only the value of an input may change: no colour, no limit, no callback."""
    updates = content.get("updates")
    return (
        isinstance(content.get("uuid"), str)
        and isinstance(updates, dict)
        and set(updates) <= {"value"}
    )


def _is_click(content: dict[str, Any]) -> bool:
    return (
        content.get("event_type") == "click"
        and isinstance(content.get("modifier"), str | None)
        and isinstance(content.get("screen_pos"), list | tuple)
        and all(_is_numbers(one, 2) for one in content["screen_pos"])
        and _is_numbers(content.get("ray_origin"), 3)
        and _is_numbers(content.get("ray_direction"), 3)
    )


def _is_picture(content: dict[str, Any]) -> bool:
    return isinstance(content.get("render_uuid"), str)


def _is_push(content: dict[str, Any]) -> bool:
    """A drag of the skin with Ctrl."""
    return (
        isinstance(content.get("name"), str)
        and content.get("phase") in ("start", "update", "end")
        and content.get("button") == "left"
        and content.get("modifier") == "cmd/ctrl"
        and all(_is_numbers(content.get(one), 3) for one in ("start_position", "end_position"))
        and all(_is_numbers(content.get(one), 2) for one in ("start_screen_pos", "end_screen_pos"))
    )


def _is_camera(content: dict[str, Any]) -> bool:
    vectors = (content.get(name) for name in ("position", "look_at", "up_direction"))
    return _is_numbers(content.get("wxyz"), 4) and all(_is_numbers(one, 3) for one in vectors)


# Of messages with content: its name, and its largest size in bytes.
_CONTENTS = {"FileTransferPart": ("content", LARGEST_FILE), _PICTURE: ("payload", LARGEST_PICTURE)}
_FILES = frozenset({"FileTransferPart", "FileTransferStartUpload"})
_SHAPES: dict[str, Callable[[dict[str, Any]], bool]] = {
    "TransformControlsUpdateMessage": _is_transform,
    "TransformControlsDragStartMessage": _is_drag,
    "TransformControlsDragEndMessage": _is_drag,
    "FileTransferPartAck": _is_receipt,
    "FileTransferPart": _is_part,
    _PICTURE: _is_picture,
    "FileTransferStartUpload": _is_file,
    "GuiUpdateMessage": _is_update,
    "SceneNodeDragMessage": _is_push,
    "ScenePointerMessage": _is_click,
    _CAMERA: _is_camera,
}
