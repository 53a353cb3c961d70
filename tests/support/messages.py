"""Messages as tests write and read them, samples of them without a network, and described effectors."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from tauten.model import EffectorLayout
from tauten.model.schema import COMPONENTS, EffectorKind, EffectorSettings
from tauten.model.signals import effector_layout
from tauten.service.node import Action
from tauten.service.wire import (
    CDR,
    TEXT,
    DescribedEffector,
    EffectorMessage,
    OperatorOrder,
    Rejection,
    Tick,
    decode_effector,
    effector_json,
    encode_effector,
    typestore,
)


def point_layout(names: Sequence[str]) -> EffectorLayout:
    """The layout of effectors that are points with weight one."""
    points = [EffectorSettings(name=name, point=(0.0, 0.0, 0.0)) for name in names]
    return effector_layout(points, 1.0, {})


@dataclass(frozen=True, slots=True)
class Point:
    """geometry_msgs/PointStamped: time [ns since the epoch], frame, position [m]."""

    stamp: int
    frame: str
    xyz: tuple[float, float, float]


def encode_point(point: Point) -> bytes:
    """A point in CDR."""
    return encode_effector("point", "tip", EffectorMessage(point.stamp, point.frame, point.xyz))


def point_json(point: Point) -> bytes:
    """A point as JSON."""
    return effector_json("point", "tip", EffectorMessage(point.stamp, point.frame, point.xyz))


def decode_point(payload: bytes, encoding: str) -> Point | Rejection:
    """A point from CDR or JSON, as a node reads the target of an effector that is a point.

    Args:
        payload: the message.
        encoding: names the format and the type.
    """
    found = decode_effector("point", "tip", payload, encoding)
    if isinstance(found, Rejection):
        return found
    x, y, z = found.values
    return Point(found.stamp, found.frame, (x, y, z))


def encode_command(command: OperatorOrder) -> bytes:
    """A command of an operator in CDR, as a bridge to ROS 2 sends it."""
    store = typestore()
    return bytes(store.serialize_cdr(store.types[TEXT](data=str(command)), TEXT))


def decoded_by_mcap(log: Path) -> list[tuple[str, str, Any]]:
    """Topic, type and content of all messages of a log, as the ROS 2 reader of MCAP decodes it."""
    found = []
    with log.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        for item in reader.iter_decoded_messages():
            assert item.schema is not None
            found.append((item.channel.topic, item.schema.name, item.decoded_message))
    return found


def effector(
    name: str, kind: EffectorKind, *rest: float, weight: tuple[float, ...] | None = None
) -> DescribedEffector:
    """An effector with goal values at rest; all of its components count where no weight is given."""
    ones = (1.0,) * COMPONENTS[kind]
    return DescribedEffector(name=name, kind=kind, rest=rest, weight=weight or ones, exact=False)


def tick_of(action: Action) -> Tick:
    """A tick of an action, without times."""
    return Tick(
        stamp=1, frame="base", index=0, mode=action.mode, cause=action.cause, status="", goal=(),
        correction=(), target_stamp=0, lateness=0.0, latency=0.0, decide=0.0, step=0.0, slack=0.0,
        skipped=0, deepest_gap=0.0, complementarity=0.0, stationarity=0.0, extra_columns=0,
        clamped=action.actuation.clamped,
    )  # fmt: skip


@dataclass(frozen=True)
class Sample:
    """A message as Zenoh gives it."""

    payload: bytes
    encoding: str = CDR
    timestamp: None = None


@dataclass
class Ring:
    """Samples of one key."""

    samples: deque[Sample] = field(default_factory=deque)

    def try_recv(self) -> Sample | None:
        return self.samples.popleft() if self.samples else None


@dataclass
class Session:
    """Samples by their keys."""

    samples: dict[str, deque[Sample]] = field(default_factory=dict)

    def declare_subscriber(self, key: str, _: object) -> Ring:
        return Ring(self.samples.setdefault(str(key), deque()))
