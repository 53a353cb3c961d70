"""What messages of a browser may be: their sizes, types and fields, whoever sends them."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

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
    try:
        msgspec.convert(fields, _SHAPES[kind])
        Message.deserialize(raw)  # where viser makes no message of it, it ends the connection
    except Exception:  # whatever fields of other names and types raise
        return "wrong fields"
    return None


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


_Two = tuple[float, float]
_Three = tuple[float, float, float]
_Four = tuple[float, float, float, float]


class _Shape(msgspec.Struct, tag_field="type"):
    """Fields of a correct message that matter here, with their types; those of viser are checked by it."""


class _Transform(_Shape, tag="TransformControlsUpdateMessage"):
    name: str
    position: _Three
    wxyz: _Four


class _DragStart(_Shape, tag="TransformControlsDragStartMessage"):
    name: str


class _DragEnd(_Shape, tag="TransformControlsDragEndMessage"):
    name: str


class _Receipt(_Shape, tag="FileTransferPartAck"):
    """Of a part of a file that the browser was sent."""

    transfer_uuid: str
    source_component_uuid: str | None = None


class _File(_Shape, tag=FILE):
    """A file in one part."""

    source_component_uuid: str
    part_count: Literal[1]
    size_bytes: Annotated[int, msgspec.Meta(gt=0, le=LARGEST_FILE)]


class _Part(_Shape, tag=PART):
    source_component_uuid: str
    part_index: Literal[0]


class _Picture(_Shape, tag=PICTURE):
    render_uuid: str


class _Value(msgspec.Struct, forbid_unknown_fields=True):
    """Only the value of an input may change: no colour, no limit, no callback."""

    value: Any = None


class _Update(_Shape, tag="GuiUpdateMessage"):
    uuid: str
    updates: _Value


class _Click(_Shape, tag="ScenePointerMessage"):
    event_type: Literal["click"]
    screen_pos: list[_Two]
    ray_origin: _Three
    ray_direction: _Three
    modifier: str | None = None


class _Push(_Shape, tag="SceneNodeDragMessage"):
    """A drag of the skin with Ctrl."""

    name: str
    phase: Literal["start", "update", "end"]
    button: Literal["left"]
    modifier: Literal["cmd/ctrl"]
    start_position: _Three
    end_position: _Three
    start_screen_pos: _Two
    end_screen_pos: _Two


class _Camera(_Shape, tag=CAMERA):
    wxyz: _Four
    position: _Three
    look_at: _Three
    up_direction: _Three


# Of messages with content: its name, and its largest size in bytes.
_CONTENTS = {PART: ("content", LARGEST_FILE), PICTURE: ("payload", LARGEST_PICTURE)}
_SHAPES = {str(one.__struct_config__.tag): one for one in _Shape.__subclasses__()}
