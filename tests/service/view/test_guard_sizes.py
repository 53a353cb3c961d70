"""Large messages: only pictures and files that are expected, and nothing else is decoded."""

from __future__ import annotations

import struct
from typing import Any

import msgspec
import pytest
from support.viewers import Shown, browser, send, wait_until


def png(height: int, width: int, *chunks: bytes, first: bytes = b"") -> bytes:
    """The begin of a PNG, without pixels."""
    size = struct.pack(">II", width, height) + b"\x08\x06\x00\x00\x00"
    parts = (b"IHDR" + size, *chunks, b"IDAT" + bytes(10**6))
    return b"\x89PNG\r\n\x1a\n" + first + b"".join(
        struct.pack(">I", len(part) - 4) + part + bytes(4) for part in parts
    )  # fmt: skip


def test_only_a_picture_that_was_asked_for_is_taken(refusing: Shown) -> None:
    guard, picture = refusing.guard, {"payload": png(30, 40), "render_uuid": "0"}
    with browser(refusing) as page:
        assert wait_until(lambda: guard.browsers == 1)
        send(page, "GetRenderResponseMessage", **picture)
        assert wait_until(lambda: guard.refused["too large"] == 1)
        with guard.picture(30, 40):
            send(page, "GetRenderResponseMessage", **picture)
            send(page, "GetRenderResponseMessage", **picture)
            assert wait_until(lambda: guard.refused["too large"] == 2)
        with guard.picture(30, 40):
            pass
        send(page, "GetRenderResponseMessage", **picture)
        assert wait_until(lambda: guard.refused["too large"] == 3)
        assert guard.refused.total() == 3


@pytest.mark.parametrize(
    "payload",
    [
        png(40, 30),
        png(20_000, 20_000),
        png(30, 40, b"IHDR" + struct.pack(">II", 20_000, 20_000) + bytes(5)),
        png(30, 40, b"acTL" + bytes(8)),
        png(30, 40, *[b"tEXt"] * 1000),
        png(30, 40, first=b"\x00"),
        b"\x89PNG" + bytes(10**6),
        png(30, 40)[:33],
        b"\xff\xd8\xff\xe0",
    ],
    ids=["turned", "bomb", "two headers", "film", "texts", "shifted", "junk", "cut", "JPEG"],
)
def test_a_picture_of_another_size_is_not_decoded(refusing: Shown, payload: bytes) -> None:
    with browser(refusing) as page:
        assert wait_until(lambda: refusing.guard.browsers == 1)
        with refusing.guard.picture(30, 40):
            send(page, "GetRenderResponseMessage", payload=payload, render_uuid="0")
            assert wait_until(lambda: refusing.guard.refused["wrong value"] == 1)


def test_large_messages_are_refused_before_they_are_decoded(
    refusing: Shown, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A list of eight million numbers takes the loop a second, and 800 MB."""
    guard, sizes, decode = refusing.guard, list[int](), msgspec.msgpack.decode
    (component,) = refusing.session.program.uploads
    numbers = {"payload": [0] * (2**23 - 1000), "render_uuid": "0"}

    def counted(raw: bytes, **settings: Any) -> Any:
        sizes.append(len(raw))
        return decode(raw, **settings)

    monkeypatch.setattr(msgspec.msgpack, "decode", counted)
    with browser(refusing) as first:
        assert wait_until(lambda: guard.browsers == 1)
        with browser(refusing) as second, guard.picture(30, 40):
            assert wait_until(lambda: guard.browsers == 2)
            send(second, "GetRenderResponseMessage", **numbers)
            send(second, "GetRenderResponseMessage", payload=png(30, 40), render_uuid="0")
            assert wait_until(lambda: guard.refused["too large"] == 2)
            send(first, "GetRenderResponseMessage", **numbers)  # may be large, and is no picture
            assert wait_until(lambda: guard.refused["not a message of viser"] == 1)
        part = {"source_component_uuid": component, "transfer_uuid": "0", "part_index": 0}
        send(first, "FileTransferPart", content=bytes(20_000), **part)  # was not announced
        assert wait_until(lambda: guard.refused["too large"] == 3)
        announced = {"filename": "x.csv", "mime_type": "text/csv", "part_count": 1}
        for content in (bytes(70_000), b"x,y,z\n0.1,0.01,0.01" + b"0" * 40_000 + b"\n"):
            send(
                first, "FileTransferStartUpload", size_bytes=40_020, **announced,
                source_component_uuid=component, transfer_uuid="0",
            )  # fmt: skip
            send(first, "FileTransferPart", content=content, **part)
        assert wait_until(lambda: max(sizes) > 40_000)
    assert guard.refused["too large"] == 4
    assert guard.refused.total() == 5
    assert max(sizes) < 65_536
