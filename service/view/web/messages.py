"""What messages of a browser may be: their sizes, types and fields, whoever sends them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import msgspec
from viser._messages import Message

LARGEST_MESSAGE = 16_384  # bytes; the largest correct one without content has a few hundred
LARGEST_FILE = 49_152  # bytes
LARGEST_PICTURE = 2**23  # bytes
LARGEST_FRAME = LARGEST_PICTURE + LARGEST_MESSAGE  # bytes; a larger one ends its connection
LARGEST_NUMBER = 1e6
CAMERA, PICTURE = "ViewerCameraMessage", "GetRenderResponseMessage"
FILE, PART = "FileTransferStartUpload", "FileTransferPart"

_MOST_TEXT = 200  # characters
_MOST_VALUES = 32  # of a list or mapping
_DEPTH = 4
_HEADER = b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR"


class _LargePicture(msgspec.Struct, tag=PICTURE, tag_field="type", forbid_unknown_fields=True):
    payload: bytes
    render_uuid: str


class _LargePart(msgspec.Struct, tag=PART, tag_field="type", forbid_unknown_fields=True):
    source_component_uuid: str | None
    transfer_uuid: str
    part_index: int
    content: bytes


_LARGE = msgspec.msgpack.Decoder(_LargePicture | _LargePart)


def decoded(raw: bytes) -> dict[str, Any]:
    """Fields of a message; none of what is no message.

    Of large ones there are two types alone: no list of millions is made of what is another one.
    """
    try:
        if len(raw) > LARGEST_MESSAGE:
            large = _LARGE.decode(raw)
            kind = PICTURE if isinstance(large, _LargePicture) else PART
            return {"type": kind, **msgspec.structs.asdict(large)}
        content = msgspec.msgpack.decode(raw)
    except (msgspec.DecodeError, RecursionError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def message_type(content: dict[str, Any]) -> str:
    """Name of a message's type; "" of what is no message."""
    return str(content.get("type", ""))


def problem(raw: bytes, content: dict[str, Any]) -> str | None:
    """Why a message is refused, whoever sends it; None where it is correct."""
    kind = message_type(content)
    if not kind:
        return "not a message of viser"
    if kind not in _SHAPES:
        return f"type {kind[:40]}"
    name, largest = _CONTENTS.get(kind, ("", 0))
    fields, part = {key: content[key] for key in content if key != name}, content.get(name, b"")
    if not isinstance(part, bytes) or len(part) > largest or not is_bounded(fields, _DEPTH):
        return "values out of bounds"
    return None if _SHAPES[kind](fields) and _is_read(raw) else "wrong fields"


def picture_size(payload: bytes) -> tuple[int, int] | None:
    """Height and width of a PNG by its header; None of what is none, has another header, or moves."""
    if not payload.startswith(_HEADER):
        return None
    width, height = (int.from_bytes(payload[i : i + 4], "big") for i in (16, 20))
    place = 33
    for _ in range(_MOST_VALUES):
        kind = payload[place + 4 : place + 8]
        if kind == b"IDAT":
            return height, width
        if len(kind) < 4 or kind in (b"IHDR", b"acTL"):
            break
        place += 12 + int.from_bytes(payload[place : place + 4], "big")
    return None


def _is_read(raw: bytes) -> bool:
    """Whether viser makes a message of it: where it cannot, it ends the connection."""
    try:
        Message.deserialize(raw)
    except Exception:  # whatever fields of other names and types raise
        return False
    return True


def is_bounded(value: object, depth: int) -> bool:
    """Whether a value is made of short texts, and of finite numbers that are not larger than 1e6."""
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
_CONTENTS = {PART: ("content", LARGEST_FILE), PICTURE: ("payload", LARGEST_PICTURE)}
_SHAPES: dict[str, Callable[[dict[str, Any]], bool]] = {
    "TransformControlsUpdateMessage": _is_transform,
    "TransformControlsDragStartMessage": _is_drag,
    "TransformControlsDragEndMessage": _is_drag,
    "FileTransferPartAck": _is_receipt,
    PART: _is_part,
    PICTURE: _is_picture,
    FILE: _is_file,
    "GuiUpdateMessage": _is_update,
    "SceneNodeDragMessage": _is_push,
    "ScenePointerMessage": _is_click,
    CAMERA: _is_camera,
}
