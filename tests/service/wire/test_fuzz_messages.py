"""Damaged and hostile messages: every decoder returns a message or a `Rejection` and raises nothing."""

from __future__ import annotations

import json
import random
import struct
from collections.abc import Callable

import pytest
from support.messages import Point, decode_point, encode_command, encode_point, point_json

from tauten.service.codec.messages import typestore
from tauten.service.wire import (
    CDR,
    JSON,
    Cause,
    Diagnostic,
    Joints,
    Level,
    LockOrder,
    Mode,
    OperatorCommand,
    Rejection,
    RejectionReason,
    Tick,
    decode_command,
    decode_health,
    decode_joints,
    decode_tick,
    encode_health,
    encode_joints,
    encode_tick,
)

pytestmark = pytest.mark.versions

CABLES = ("lower", "upper")
POINT = Point(10**18, "base", (0.1, 0.2, 0.3))
TICK = Tick(
    10**18, "base", 7, Mode.RUN, Cause.NONE, "OK", ((0.1, 0.2, 0.3),), ((0.0, 0.0, 0.0),), 10**18,
    1e-4, 2e-3, 1e-3, 5e-3, 1e-2, 0, 1e-3, 0.0, 0.0, 0, False, (0.1, 0.2, 0.3), (0.0, 0.0, 0.0), 4,
)  # fmt: skip
HEALTH = [Diagnostic("targets", Level.WARN, "2 refused", {"accepted": "5", "refused": "2"})]

Decoder = Callable[[bytes], object]
# An honest message of each kind, and what decodes it.
KINDS: dict[str, tuple[bytes, Decoder]] = {
    "point": (encode_point(POINT), lambda payload: decode_point(payload, CDR)),
    "point as JSON": (point_json(POINT), lambda payload: decode_point(payload, JSON)),
    "joints": (
        encode_joints(Joints(10**18, "base", CABLES, (0.1, 0.2), (1.0, 2.0))),
        lambda payload: decode_joints(payload, CDR, CABLES),
    ),
    "tick": (encode_tick(TICK), decode_tick),
    "health": (encode_health(10**18, "beam", HEALTH), decode_health),
    "command": (
        encode_command(OperatorCommand.STOP),
        lambda payload: decode_command(payload, CDR),
    ),
    "lock": (
        encode_command(LockOrder("bellows", position=-1.5e-6)),
        lambda payload: decode_command(payload, CDR),
    ),
    "command as JSON": (b'{"data": "stop"}', lambda payload: decode_command(payload, JSON)),
}
VALUES = (None, True, [], {}, "", "x", -1, 10**400, 1e308, [[]] * 3, {"x": {}})


def damaged(honest: bytes, change: random.Random) -> bytes:
    """A message with some bytes changed, removed, added or repeated, or entirely random."""
    data = bytearray(honest)
    kind = change.randrange(5)
    if kind == 0:
        return change.randbytes(change.randrange(300))
    if kind == 1:
        return bytes(data[: change.randrange(len(data))])
    if kind == 2:
        return bytes(data) + change.randbytes(change.randrange(1, 40))
    for _ in range(change.randrange(1, 6)):
        data[change.randrange(len(data))] = change.choice((0, 1, 0x7F, 0x80, 0xFF, 4))
    if kind == 3:
        place = change.randrange(len(data))
        data[place:place] = data[: change.randrange(len(data))]
    return bytes(data)


def check(name: str, seeds: range) -> None:
    honest, decode = KINDS[name]
    assert not isinstance(decode(honest), Rejection)
    refused = 0
    for seed in seeds:
        found = decode(damaged(honest, random.Random(seed)))
        assert found is not None
        refused += isinstance(found, Rejection)
    assert refused > len(seeds) // 4


@pytest.mark.parametrize("name", list(KINDS))
def test_a_damaged_message_is_decoded_or_refused(name: str) -> None:
    check(name, range(1500))


@pytest.mark.slow
@pytest.mark.parametrize("name", list(KINDS))
def test_many_damaged_messages_are_decoded_or_refused(name: str) -> None:
    check(name, range(10_000, 210_000))


@pytest.mark.parametrize("error", [struct.error, AssertionError, RecursionError])
def test_whatever_the_library_raises_is_a_rejection(
    monkeypatch: pytest.MonkeyPatch, error: type[Exception]
) -> None:
    """Libraries of earlier versions raise other errors than SerdeError for what is cut off."""

    def fail(*_: object) -> None:
        raise error("unpack requires a buffer of 48 bytes")

    monkeypatch.setattr(type(typestore()), "deserialize_cdr", fail)
    found = decode_tick(encode_tick(TICK))
    assert isinstance(found, Rejection)
    assert found.reason is RejectionReason.MALFORMED


def test_json_of_any_shape_is_decoded_or_refused() -> None:
    for value in VALUES:
        for fields in (value, {"point": value}, {"point": {"x": value, "y": 0, "z": 0}},
                       {"point": {"x": 0, "y": 0, "z": 0}, "header": value},
                       {"point": {"x": 0, "y": 0, "z": 0}, "header": {"stamp": value}},
                       {"data": value}):  # fmt: skip
            payload = json.dumps(fields).encode()
            for found in (decode_point(payload, JSON), decode_command(payload, JSON)):
                assert isinstance(found, Point | OperatorCommand | Rejection)


def test_a_level_that_does_not_exist_is_refused() -> None:
    honest = encode_health(10**18, "beam", HEALTH)
    (place,) = [i for i in range(len(honest)) if _level_at(honest, i)]
    payload = honest[:place] + b"\x4d" + honest[place + 1 :]
    found = decode_health(payload)
    assert isinstance(found, Rejection)
    assert "found level 77" in found.detail


def _level_at(honest: bytes, place: int) -> bool:
    """Whether a byte is the level: another allowed one there changes the level alone."""
    found = decode_health(honest[:place] + bytes([Level.STALE]) + honest[place + 1 :])
    if isinstance(found, Rejection) or "targets" not in found:
        return False
    return found["targets"] == Diagnostic("targets", Level.STALE, "2 refused", HEALTH[0].values)


@pytest.mark.parametrize(
    "order",
    [
        LockOrder("bellows", position=-1.5e-6),
        LockOrder("tendon_1", force=12.25),
        LockOrder("tendon_1", position=0.1 + 0.2),
        LockOrder("bellows"),
    ],
)
def test_lock_orders_survive_the_wire(order: LockOrder) -> None:
    assert decode_command(encode_command(order), CDR) == order
    assert decode_command(json.dumps({"data": str(order)}).encode(), JSON) == order


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("lock", RejectionReason.UNKNOWN),
        ("lock bellows", RejectionReason.UNKNOWN),
        ("lock bellows volume 1.0", RejectionReason.UNKNOWN),
        ("lock bellows  position 1.0", RejectionReason.UNKNOWN),
        ("unlock", RejectionReason.UNKNOWN),
        ("unlock a b", RejectionReason.UNKNOWN),
        ("lock bellows position one", RejectionReason.MALFORMED),
        ("lock bellows force nan", RejectionReason.NOT_FINITE),
        ("lock bellows force 1e999", RejectionReason.NOT_FINITE),
    ],
)
def test_bad_lock_orders_are_refused(text: str, reason: RejectionReason) -> None:
    found = decode_command(json.dumps({"data": text}).encode(), JSON)
    assert isinstance(found, Rejection)
    assert found.reason is reason
