"""Random frames and requests from a browser: the viewer goes on, refuses, and moves nothing out of reach."""

from __future__ import annotations

import logging
import random
import socket
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from support.viewers import CAMERA, GIZMO, Shown, browser, drag, showing, wait_until
from websockets.exceptions import ConnectionClosed

from tauten.model import Robot
from tauten.service.frames import SimulatedRobot
from tauten.service.setup import load_setup
from tauten.service.wire import reach_of

POINTER = {
    "event_type": "click",
    "ray_origin": (0.05, -1.0, 0.01),
    "ray_direction": (0.0, 1.0, 0.0),
    "screen_pos": ((0.5, 0.5),),
    "modifier": None,
}
GIZMO_FIELDS: dict[str, Any] = {
    "name": GIZMO, "wxyz": (1.0, 0.0, 0.0, 0.0), "position": (0.1, 0.01, 0.01), "owner": "",
}  # fmt: skip
MESSAGES: tuple[tuple[str, dict[str, Any]], ...] = (
    ("ViewerCameraMessage", CAMERA),
    ("GuiUpdateMessage", {"uuid": "", "updates": {"value": 1.0}}),
    ("TransformControlsUpdateMessage", GIZMO_FIELDS),
    ("TransformControlsDragStartMessage", {"name": GIZMO}),
    ("TransformControlsDragEndMessage", {"name": GIZMO}),
    ("ScenePointerMessage", POINTER),
    ("FileTransferPartAck", {"source_component_uuid": None, "transfer_uuid": "", "transferred_bytes": 0}),
)  # fmt: skip
ODD: tuple[Any, ...] = (
    None, True, False, 0, -1, 2**63, 1e300, float("nan"), float("inf"), "", "tip", "\x00", "ÿ" * 300,
    (), (0.0,), (0.0, 0.0, 0.0), (0.0,) * 4, (0.0,) * 1000, {}, {"value": 1}, {"": {}}, b"\xff",
    ((),), ((0.1, 0.2, 0.3),), [[[[[[1]]]]]], 1e5, -1e5,
)  # fmt: skip


@pytest.fixture
def shown(beam_file: Path, beam: Robot) -> Iterator[Shown]:
    """The small robot, simulated."""
    with showing(SimulatedRobot(load_setup(beam_file), load_setup(beam_file))) as found:
        yield found


def frame(rng: random.Random, inputs: list[str]) -> bytes | str:
    """What a browser might send: a message with some fields changed, a damaged one, or noise."""
    kind, fields = rng.choice(MESSAGES)
    fields = dict(fields)
    if "uuid" in fields and rng.random() < 0.8:
        fields["uuid"] = rng.choice(inputs)
    for _ in range(rng.randrange(3)):
        choice = rng.randrange(4)
        if choice == 0 and fields:
            fields.pop(rng.choice(list(fields)))
        elif choice == 1:
            fields[rng.choice(["type", "extra", "self", "client_id", "__class__"])] = rng.choice(
                ODD
            )
        elif fields:
            fields[rng.choice(list(fields))] = rng.choice(ODD)
    if "updates" in fields and rng.random() < 0.5:
        fields["updates"] = {"value": rng.choice(ODD)}
    return damaged(rng, msgspec.msgpack.encode({"type": kind, **fields}))


def damaged(rng: random.Random, message: bytes) -> bytes | str:
    """Half of all messages as they are, the others with some bytes changed, cut, or replaced by noise."""
    raw, choice = bytearray(message), rng.randrange(8)
    if choice == 0:
        for _ in range(rng.randrange(1, 6)):
            raw[rng.randrange(len(raw))] = rng.randrange(256)
    elif choice == 1:
        return message[: rng.randrange(len(raw))]
    elif choice == 2:
        return rng.randbytes(rng.randrange(200))
    elif choice == 3:
        return rng.choice(["", "{}", "\x00", "x" * 1000])
    return bytes(raw)


def errors(caplog: pytest.LogCaptureFixture) -> list[str]:
    """What the viewer has logged as an error."""
    return [
        f"{record.getMessage()} {record.exc_info}"
        for record in caplog.records
        if record.levelno >= logging.ERROR and not record.name.startswith("websockets.client")
    ]


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))]
)
def test_random_frames_end_nothing(
    shown: Shown,
    beam: Robot,
    seed: int,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    raised = list[object]()
    monkeypatch.setattr(threading, "excepthook", raised.append)
    rng, inputs = random.Random(seed), list(shown.server.gui._gui_input_handle_from_uuid)
    rest, targets = beam.effector(beam.rest())[0], shown.session.targets
    sent = lost = 0
    while sent < 400:
        with browser(shown) as page, suppress(ConnectionClosed):
            assert wait_until(lambda: shown.guard.browsers == 1)
            while sent < 400:
                sent += 1
                page.send(frame(rng, inputs))
                assert np.isfinite(targets.values).all()
                distance = np.linalg.norm(targets.of(0)[:3] - rest)
                assert distance <= reach_of(beam.size) * (1.0 + 1e-9)
        lost += sent < 400
        assert wait_until(lambda: shown.guard.browsers == 0)
    assert lost == 0  # no frame of a size that is allowed ends the connection
    assert shown.guard.refused.total() > 100
    assert errors(caplog) == []
    assert raised == []
    # and it works as before
    shown.session.arm()
    with browser(shown) as page:
        drag(page, (0.1, 0.01, 0.0123))
        assert wait_until(lambda: abs(float(targets.of(0)[2]) - 0.0123) < 1e-9)


def request(rng: random.Random, port: int) -> bytes:
    """What somebody might send to the port: a request with odd parts, a broken handshake, or noise."""
    method = rng.choice(["GET", "HEAD", "POST", "PUT", "OPTIONS", "get", "", "G" * 3000])
    path = rng.choice(
        ["/", "/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/\x00", "/index.html",
         "/assets/..%2f..%2f..%2fetc/passwd", "/" + "a" * 9000, "http://evil.example/", "*", "/?%ff"]
    )  # fmt: skip
    lines = [f"{method} {path} {rng.choice(['HTTP/1.1', 'HTTP/1.0', 'HTTP/9', ''])}"]
    headers = (
        f"Host: 127.0.0.1:{port}", "Host: evil.example", "Connection: Upgrade", "Upgrade: websocket",
        "Sec-WebSocket-Version: 13", "Sec-WebSocket-Version: 99", "Sec-WebSocket-Key: AAAA",
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==", "Origin: null", f"Origin: http://127.0.0.1:{port}",
        "Content-Length: 999999999999", "Content-Length: -1", "Transfer-Encoding: chunked",
        "X: " + "y" * 9000, "no colon", ": empty", "\x00: \x00", "Range: bytes=0-99999999999",
    )  # fmt: skip
    lines += rng.sample(headers, rng.randrange(8))
    raw = ("\r\n".join(lines) + "\r\n\r\n").encode("latin-1")
    choice = rng.randrange(4)
    if choice == 0:
        return raw[: rng.randrange(len(raw) + 1)]
    if choice == 1:
        return rng.randbytes(rng.randrange(300))
    return raw + (rng.randbytes(50) if choice == 2 else b"")


@pytest.mark.long
def test_random_requests_end_nothing(shown: Shown, caplog: pytest.LogCaptureFixture) -> None:
    rng, port = random.Random(5), shown.server.get_port()
    for _ in range(250):
        with socket.create_connection(("127.0.0.1", port), timeout=5.0) as connection:
            connection.settimeout(0.02)
            with suppress(OSError):
                connection.sendall(request(rng, port))
                answer = connection.recv(65536)
                assert b"root:" not in answer
    assert errors(caplog) == []
    assert wait_until(lambda: shown.guard.browsers == 0)
    with browser(shown):
        assert wait_until(lambda: shown.guard.browsers == 1)
