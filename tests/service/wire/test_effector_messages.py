"""Messages of effectors of every kind: round trips, what ROS would have, what is refused, any bytes."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.effectors import ALL_KINDS, solid
from support.messages import Point, encode_point

from tauten.model.schema import EffectorKind
from tauten.service.codec.messages import POINT, POSE
from tauten.service.wire import (
    CDR,
    EFFECTOR_RING,
    JOINTS,
    JSON,
    MESSAGE_TYPES,
    EffectorMessage,
    EffectorSubscriber,
    Rejection,
    RejectionReason,
    decode_effector,
    effector_json,
    encode_effector,
    from_cdr,
    reach_of,
)

KINDS: list[EffectorKind] = ["point", "frame", "centre", "distance", "length", "volume"]
POSE_VALUES = (0.1, -0.2, 0.3, 0.5, -0.5, 0.5, 0.5)
EXAMPLES: dict[EffectorKind, tuple[float, ...]] = {
    "point": (0.1, -0.2, 0.3), "centre": (0.1, -0.2, 0.3), "frame": POSE_VALUES,
    "distance": (0.25,), "length": (0.25,), "volume": (6e-6,),
}  # fmt: skip
STAMP = 1_700_000_000_123_456_789


def message(kind: EffectorKind) -> EffectorMessage:
    return EffectorMessage(STAMP, "base", EXAMPLES[kind])


@pytest.mark.parametrize("kind", KINDS)
def test_values_survive_cdr_and_json(kind: EffectorKind) -> None:
    cdr, text = (
        encode_effector(kind, "tip", message(kind)),
        effector_json(kind, "tip", message(kind)),
    )
    assert decode_effector(kind, "tip", cdr, f"{CDR};{MESSAGE_TYPES[kind]}") == message(kind)
    assert decode_effector(kind, "tip", text, JSON) == message(kind)


def test_a_pose_has_the_fields_of_ros() -> None:
    found: Any = from_cdr(POSE, encode_effector("frame", "tip", message("frame")))
    position, orientation = found.pose.position, found.pose.orientation
    assert (position.x, position.y, position.z) == POSE_VALUES[:3]
    assert (orientation.w, orientation.x, orientation.y, orientation.z) == POSE_VALUES[3:]
    assert found.header.frame_id == "base"
    fields = json.loads(effector_json("frame", "tip", message("frame")))
    assert fields["pose"]["orientation"] == {"x": -0.5, "y": 0.5, "z": 0.5, "w": 0.5}


def test_a_scalar_is_a_joint_state_with_its_name() -> None:
    found: Any = from_cdr(JOINTS, encode_effector("volume", "room", message("volume")))
    assert found.name == ["room"]
    assert found.position.tolist() == [6e-6]
    for text in (b'{"position": [0.1]}', b'{"position": [0.1], "name": ["room"]}'):
        decoded = decode_effector("volume", "room", text, JSON)
        assert decoded == EffectorMessage(0, "", (0.1,))


def refused(kind: EffectorKind, payload: bytes, encoding: str) -> Rejection:
    found = decode_effector(kind, "tip", payload, encoding)
    assert isinstance(found, Rejection), found
    assert "\n" not in found.detail
    return found


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("sent", KINDS)
def test_a_target_of_another_kind_is_refused(kind: EffectorKind, sent: EffectorKind) -> None:
    if MESSAGE_TYPES[kind] == MESSAGE_TYPES[sent]:
        return
    payload = encode_effector(sent, "tip", message(sent))
    found = refused(kind, payload, f"{CDR};{MESSAGE_TYPES[sent]}")
    assert found.reason is RejectionReason.WRONG_TYPE
    assert f"expected {MESSAGE_TYPES[kind]} for effector 'tip' of kind '{kind}'" in found.detail
    found = refused(kind, effector_json(sent, "tip", message(sent)), JSON)
    assert found.reason is RejectionReason.WRONG_TYPE
    refused(kind, payload, CDR)


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ((0.1, 0.0, 0.0, 1.1, 0.0, 0.0, 0.0), RejectionReason.NO_ROTATION),
        ((0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), RejectionReason.NO_ROTATION),
        ((0.1, 0.0, 0.0, 1e300, 0.0, 0.0, 0.0), RejectionReason.NO_ROTATION),
        ((0.1, 0.0, 0.0, math.nan, 0.0, 0.0, 0.0), RejectionReason.NOT_FINITE),
        ((0.1, 0.0, math.inf, 1.0, 0.0, 0.0, 0.0), RejectionReason.NOT_FINITE),
    ],
)
def test_a_pose_that_is_none_is_refused(values: tuple[float, ...], reason: RejectionReason) -> None:
    wrong = EffectorMessage(0, "", values)
    assert refused("frame", encode_effector("frame", "tip", wrong), CDR).reason is reason
    if math.isfinite(sum(values)):
        assert refused("frame", effector_json("frame", "tip", wrong), JSON).reason is reason


def test_both_signs_of_a_quaternion_are_accepted() -> None:
    for sign in (1.0, -1.0):
        values = (*POSE_VALUES[:3], *(sign * value for value in POSE_VALUES[3:]))
        payload = encode_effector("frame", "tip", EffectorMessage(0, "", values))
        assert decode_effector("frame", "tip", payload, CDR) == EffectorMessage(0, "", values)


@pytest.mark.parametrize(
    ("payload", "reason"),
    [
        (b'{"position": []}', RejectionReason.WRONG_SHAPE),
        (b'{"position": [0.1, 0.2]}', RejectionReason.WRONG_SHAPE),
        (b'{"position": [0.1], "name": ["other"]}', RejectionReason.WRONG_SHAPE),
        (b'{"position": [true]}', RejectionReason.MALFORMED),
        (b'{"position": 3}', RejectionReason.MALFORMED),
        (b'{"position": [NaN]}', RejectionReason.NOT_FINITE),
        (b'{"position": [0.1], "header": {"stamp": {"sec": -1}}}', RejectionReason.MALFORMED),
        (b"[]", RejectionReason.MALFORMED),
        (b"{", RejectionReason.MALFORMED),
    ],
)
def test_a_scalar_that_is_none_is_refused(payload: bytes, reason: RejectionReason) -> None:
    assert refused("distance", payload, JSON).reason is reason


@pytest.mark.long
@settings(max_examples=300)
@given(st.sampled_from(KINDS), st.binary(max_size=200), st.sampled_from([CDR, JSON, "text/plain"]))
def test_any_bytes_are_values_or_refused(kind: EffectorKind, payload: bytes, form: str) -> None:
    assert isinstance(decode_effector(kind, "tip", payload, form), EffectorMessage | Rejection)


@settings(max_examples=300)
@given(st.sampled_from(KINDS), st.integers(0, 10_000), st.integers(0, 255))
def test_any_changed_byte_is_values_or_refused(kind: EffectorKind, place: int, byte: int) -> None:
    payload = bytearray(encode_effector(kind, "tip", message(kind)))
    payload[place % len(payload)] = byte
    found = decode_effector(kind, "tip", bytes(payload), CDR)
    if isinstance(found, EffectorMessage):
        assert np.isfinite(found.values).all()
        assert len(found.values) == len(EXAMPLES[kind])


trees = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(["pose", "position", "orientation", "x", "w", "name", "header"]), inner
        )
    ),
    max_leaves=12,
)


@pytest.mark.long
@settings(max_examples=100)
@given(st.sampled_from(KINDS), trees)
def test_any_json_is_values_or_refused(kind: EffectorKind, value: object) -> None:
    found = decode_effector(kind, "tip", json.dumps(value).encode(), JSON)
    assert isinstance(found, EffectorMessage | Rejection)


class Queue:
    """A ring of samples that is filled by hand."""

    def __init__(self) -> None:
        self.samples: list[Any] = []

    def try_recv(self) -> Any:
        return self.samples.pop(0) if self.samples else None


@dataclass(frozen=True)
class Arrival:
    """When a sample arrived, as Zenoh writes it down."""

    wall: float  # s since the epoch

    def get_time(self) -> datetime:
        return datetime.fromtimestamp(self.wall, UTC)


class Sample:
    """One sample as Zenoh gives it."""

    def __init__(
        self, payload: bytes, encoding: str = CDR, timestamp: Arrival | None = None
    ) -> None:
        self.payload, self.encoding, self.timestamp = payload, encoding, timestamp


def test_a_subscriber_of_all_kinds_gives_goal_values() -> None:
    robot = solid()
    layout, rest = robot.effector_layout, robot.effector_values(robot.rest())
    queues = [Queue() for _ in ALL_KINDS]
    subscriber = EffectorSubscriber(queues, "base", layout, rest, reach_of(robot.size), 0.5)
    wanted = layout.moved(rest, 1e-3 / layout.units)
    for i, (kind, name) in enumerate(zip(layout.kinds, layout.names, strict=True)):
        values = tuple(wanted[layout.values_of(i)].tolist())
        payload = encode_effector(kind, name, EffectorMessage(0, "base", values))
        queues[i].samples.append(Sample(payload))
    assert len(subscriber.read(1.0, 0.0)) == len(ALL_KINDS)
    np.testing.assert_allclose(subscriber.latest(1.0, rest), wanted)
    np.testing.assert_allclose(subscriber.complete(1.0), wanted)


@pytest.mark.parametrize(
    ("name", "values", "text"),
    [
        ("tool", (10.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), "m from the effector at rest"),
        ("span", (-0.01,), "a distance of -0.01 m, allowed are 0 to "),
        ("span", (82.0,), "a distance of 82 m, allowed are 0 to "),
        ("sensor", (5.0,), "a length of 5 m"),
        ("room", (6.0,), "a volume of 6 m³, allowed are 0 to "),
    ],
)
def test_values_far_out_of_reach_are_refused(
    name: str, values: tuple[float, ...], text: str
) -> None:
    """Millimetres for metres, millilitres for cubic metres."""
    robot = solid()
    layout, rest = robot.effector_layout, robot.effector_values(robot.rest())
    queues = [Queue() for _ in ALL_KINDS]
    subscriber = EffectorSubscriber(queues, "base", layout, rest, reach_of(robot.size), 0.5)
    number = layout.names.index(name)
    payload = encode_effector(layout.kinds[number], name, EffectorMessage(0, "base", values))
    queues[number].samples.append(Sample(payload))
    assert subscriber.read(1.0, 0.0) == []
    assert subscriber.counts.refused == {"out_of_reach": 1}
    assert text in subscriber.counts.last_rejection


def test_a_point_for_a_frame_is_counted_by_its_reason() -> None:
    robot = solid()
    layout, rest = robot.effector_layout, robot.effector_values(robot.rest())
    queues = [Queue() for _ in ALL_KINDS]
    subscriber = EffectorSubscriber(queues, "base", layout, rest, reach_of(robot.size), 0.5)
    payload = encode_point(Point(0, "", (0.1, 0.0, 0.0)))
    for _ in range(EFFECTOR_RING):
        queues[1].samples.append(Sample(payload, f"{CDR};{POINT}"))
    assert subscriber.read(1.0, 0.0) == []
    assert subscriber.counts.refused == {"wrong_type": EFFECTOR_RING}


def test_targets_that_arrive_after_a_late_tick_was_due_are_those_of_the_next() -> None:
    """Goals changed by twice the way of a period in a late tick, and then not at all."""
    robot = solid()
    layout, rest = robot.effector_layout, robot.effector_values(robot.rest())
    queues = [Queue() for _ in ALL_KINDS]
    subscriber = EffectorSubscriber(queues, "base", layout, rest, reach_of(robot.size), 0.5)
    number = layout.kinds.index("point")
    part, period, wall = layout.values_of(number), 0.02, 1e9
    stream = []  # a target of each period, 5 ms after its tick was due
    for target in range(8):
        x, y, z = (rest[part] + 1e-4 * target).tolist()
        payload, arrival = encode_point(Point(0, "", (x, y, z))), target * period + 0.005
        stream.append((arrival, Sample(payload, timestamp=Arrival(wall + arrival))))
    for tick, late in enumerate([0.0, 0.008, 0.0, 0.004, 0.008, 0.008, 0.0], 1):
        now = tick * period + late
        while stream[0][0] <= now:
            queues[number].samples.append(stream.pop(0)[1])
        accepted = subscriber.read(now, wall + now, late)
        assert len(accepted) == 1
        followed = subscriber.latest(now, rest)
        assert followed is not None
        np.testing.assert_allclose(followed[part] - rest[part], 1e-4 * (tick - 1), atol=1e-12)
