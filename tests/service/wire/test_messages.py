"""What goes over the wire: round trips, and rubbish that must become a Rejection."""

import json
import math
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from mcap_ros2._dynamic import generate_dynamic
from support.messages import Point, decode_point, encode_point, point_json

from tauten.service.codec.messages import (
    MAX_PAYLOAD,
    POINT,
    POSE,
)
from tauten.service.wire import (
    CDR,
    FLOAT,
    HEALTH,
    JOINTS,
    JSON,
    TEXT,
    TICK,
    Joints,
    Rejection,
    RejectionReason,
    as_cdr,
    decode_joints,
    definition,
    encode_joints,
    from_cdr,
)

finite = st.floats(allow_nan=False, allow_infinity=False)
stamps = st.integers(0, 2**31 * 10**9 - 1)
names = st.text(max_size=20)
points = st.builds(Point, stamps, names, st.tuples(finite, finite, finite))
HERE = Point(1_700_000_000_123_456_789, "base", (0.1, -0.2, 0.3))


@pytest.mark.long
@given(points)
def test_a_point_survives_cdr_and_json(point: Point) -> None:
    assert decode_point(encode_point(point), CDR) == point
    assert decode_point(point_json(point), JSON) == point


def test_the_bytes_of_a_point_are_what_ros_2_writes() -> None:
    # laid out by hand from the CDR rules: encapsulation, sec, nanosec, length and text, padding to 8
    point = Point(1_000_000_002, "ab", (1.0, 2.0, -0.5))
    expected = bytes.fromhex(
        "00010000 01000000 02000000 03000000 616200 00"
        "000000000000f03f 0000000000000040 000000000000e0bf"
    )
    assert encode_point(point) == expected


@given(st.lists(st.tuples(names, finite, finite), max_size=5), stamps)
def test_joints_survive_cdr(cables: list[tuple[str, float, float]], stamp: int) -> None:
    labels, position, effort = (tuple(c[i] for c in cables) for i in range(3))
    joints = Joints(stamp, "base", labels, position, effort)  # type: ignore[arg-type]
    assert decode_joints(encode_joints(joints), CDR, joints.names) == joints


@pytest.mark.parametrize(
    "encoding", [CDR, f"{CDR};{POINT}", "zenoh/bytes", f"{CDR};geometry_msgs/PointStamped"]
)
def test_encodings_of_cdr_that_are_read(encoding: str) -> None:
    assert decode_point(encode_point(HERE), encoding) == HERE


@pytest.mark.parametrize(
    ("payload", "encoding", "reason"),
    [
        (b"", CDR, RejectionReason.MALFORMED),
        (encode_point(HERE)[:-1], CDR, RejectionReason.MALFORMED),
        (encode_point(HERE) + bytes(8), CDR, RejectionReason.MALFORMED),
        (bytes(MAX_PAYLOAD + 1), CDR, RejectionReason.TOO_LARGE),
        (encode_point(HERE), "text/plain", RejectionReason.ENCODING),
        (encode_point(HERE), f"{CDR};{JOINTS}", RejectionReason.WRONG_TYPE),
        (encode_point(Point(0, "", (math.nan, 0.0, 0.0))), CDR, RejectionReason.NOT_FINITE),
        (encode_point(Point(0, "", (0.0, math.inf, 0.0))), CDR, RejectionReason.NOT_FINITE),
        (b'{"point": {"x": 0, "y": 0, "z": NaN}}', JSON, RejectionReason.NOT_FINITE),
        (b'{"point": {"x": 0, "y": 0}}', JSON, RejectionReason.MALFORMED),
        (b'{"point": {"x": "0", "y": 0, "z": 0}}', JSON, RejectionReason.MALFORMED),
        (b'{"point": {"x": true, "y": 0, "z": 0}}', JSON, RejectionReason.MALFORMED),
        (
            b'{"point": {"x": 1' + b"0" * 400 + b', "y": 0, "z": 0}}',
            JSON,
            RejectionReason.NOT_FINITE,
        ),
        (b"[" * 10_000, JSON, RejectionReason.MALFORMED),
        (b"[]", JSON, RejectionReason.MALFORMED),
        (b"\xff\xfe", JSON, RejectionReason.MALFORMED),
        (b'{"header": 3, "point": {"x": 0, "y": 0, "z": 0}}', JSON, RejectionReason.MALFORMED),
        (
            b'{"header": {"stamp": {"sec": 1e30}}, "point": {"x": 0, "y": 0, "z": 0}}',
            JSON,
            RejectionReason.MALFORMED,
        ),
    ],
)
def test_bad_points_are_refused_for_the_right_reason(
    payload: bytes, encoding: str, reason: RejectionReason
) -> None:
    found = decode_point(payload, encoding)
    assert isinstance(found, Rejection)
    assert found.reason is reason


@pytest.mark.parametrize(
    ("kind", "payload"),
    [
        (POINT, b'{"header": {"stamp": {"sec": 3}}, "point": {"x": 0.1, "y": 2, "z": -3}}'),
        (
            POSE,
            b'{"pose": {"position": {"x": 1, "y": 2, "z": 3}, '
            b'"orientation": {"x": 0, "y": 0.6, "z": 0, "w": 0.8}}}',
        ),
        (JOINTS, b'{"name": ["span"], "position": [0.1]}'),
        (JOINTS, b'{"position": [0.1, 0.2]}'),
        (JOINTS, b'{"name": ["a"], "position": [0.1], "velocity": [0.2], "effort": [3.0]}'),
        (TEXT, '{"data": "lock ü position 0.1"}'.encode()),
    ],
)
def test_json_becomes_the_same_message_in_cdr(kind: str, payload: bytes) -> None:
    """Logs have CDR alone; the MCAP library for ROS 2 reads it by the definition in the log."""
    made = as_cdr(payload, f"{JSON};{kind}", kind)
    assert isinstance(made, bytes)
    decode = generate_dynamic(kind, definition(kind))[kind]
    agrees(decode(made), json.loads(payload))
    assert as_cdr(made, CDR, kind) == made


def agrees(found: Any, fields: dict[str, Any]) -> None:
    """Whether a ROS message has these fields."""
    for name, value in fields.items():
        if isinstance(value, dict):
            agrees(getattr(found, name), value)
        else:
            assert getattr(found, name) == value


def test_json_of_another_type_is_not_made_to_cdr() -> None:
    for kind, payload in ((FLOAT, b'{"data": 1.0}'), (POINT, b'{"point": {"x": 1}}')):
        assert isinstance(as_cdr(payload, JSON, kind), Rejection)


def test_a_point_without_header_is_read_from_json() -> None:
    assert decode_point(b'{"point": {"x": 1, "y": 2.5, "z": -3}}', JSON) == Point(
        0, "", (1.0, 2.5, -3.0)
    )


def test_wrong_cables_are_refused() -> None:
    joints = Joints(0, "base", ("a", "b"), (0.0, 0.0), (1.0, 1.0))
    found = decode_joints(encode_joints(joints), CDR, ("b", "a"))
    assert isinstance(found, Rejection)
    assert found.reason is RejectionReason.WRONG_SHAPE
    short = encode_joints(Joints(0, "base", ("a",), (0.0,), ()))
    assert isinstance(decode_joints(short, CDR, ("a",)), Rejection)


@settings(max_examples=500)
@given(st.binary(max_size=300), st.sampled_from([CDR, JSON, "", "zenoh/bytes", ";;"]))
@example(b"\x00\x01\x00\x00" + b"\xff" * 60, CDR)
def test_random_bytes_raise_nothing(payload: bytes, encoding: str) -> None:
    for prefix in (b"", b"\x00\x01\x00\x00", b"\x00\x00\x00\x00"):
        assert isinstance(decode_point(prefix + payload, encoding), Point | Rejection)
        assert isinstance(decode_joints(prefix + payload, encoding, ("a",)), Joints | Rejection)
        for kind in (HEALTH, TICK):
            from_cdr(kind, prefix + payload)


@settings(max_examples=300)
@given(points, st.integers(0, 200), st.binary(min_size=1, max_size=4))
def test_flipped_bytes_raise_nothing(point: Point, at: int, patch: bytes) -> None:
    payload = bytearray(encode_point(point))
    at = min(at, len(payload) - 1)
    payload[at : at + len(patch)] = patch
    assert isinstance(decode_point(bytes(payload), CDR), Point | Rejection)


@pytest.mark.long
@settings(max_examples=300)
@given(
    st.recursive(
        st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(["header", "point", "stamp", "x", "y", "z", "sec"]), inner
            )
        ),
        max_leaves=20,
    )
)
def test_json_of_any_shape_raises_nothing(value: object) -> None:
    assert isinstance(decode_point(json.dumps(value).encode(), JSON), Point | Rejection)


def test_schemas_name_every_type_they_use() -> None:
    text = definition(TICK)
    for inner in ("std_msgs/Header", "geometry_msgs/Point", "builtin_interfaces/Time"):
        assert f"MSG: {inner}\n" in text
