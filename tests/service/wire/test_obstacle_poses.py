"""Poses of obstacles: what is refused, what is continued, and what happens where no more arrive."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
import pytest

from tauten.model.contact import ObstaclePose, PoseStream, pose_at
from tauten.model.numerics import Array
from tauten.service.wire import (
    CDR,
    OBSTACLE_RING,
    EffectorMessage,
    Level,
    ObstacleState,
    ObstacleSubscriber,
    Rejection,
    decode_obstacle,
    decode_wrench,
    effector_json,
    encode_effector,
    encode_obstacle,
    encode_wrench,
)

WALL = 1.8e9  # s since the epoch at the monotonic time 0
STREAM = PoseStream(largest_speed=0.5, largest_spin=2.0, timeout=0.2)
TICK = 0.02  # s
UPRIGHT = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Arrival:
    """When Zenoh wrote down that a sample had arrived [s since the epoch]."""

    seconds: float

    def get_time(self) -> datetime:
        return datetime.fromtimestamp(self.seconds, UTC)


@dataclass(frozen=True)
class Sample:
    payload: bytes
    encoding: str = CDR
    timestamp: Arrival | None = None


def depth_in_robot(name: str, pose: ObstaclePose) -> float:
    """The robot is all that lies below z = −0.5 m."""
    return max(0.0, -0.5 - float(pose.position[2]))


class Sender:
    """A ring that is filled by hand, and the subscriber that reads it."""

    def __init__(self) -> None:
        self.samples: deque[Sample] = deque(maxlen=OBSTACLE_RING)
        self.subscriber = ObstacleSubscriber({"ball": (self, STREAM)}, "base", 2e-3)  # type: ignore[dict-item]

    def try_recv(self) -> Sample | None:
        return self.samples.popleft() if self.samples else None

    def put(
        self,
        made: float,
        position: tuple[float, float, float],
        quaternion: tuple[float, float, float, float] = UPRIGHT,
        frame: str = "base",
        json: bool = False,
    ) -> None:
        """A pose that was made at a monotonic time [s]."""
        message = EffectorMessage(round(1e9 * (WALL + made)), frame, (*position, *quaternion))
        write = effector_json if json else encode_effector
        encoding = "application/json" if json else CDR
        self.samples.append(Sample(write("frame", "ball", message), encoding))

    def read(self, now: float) -> Array | None:
        """Position (3,) and velocity (3,) of the obstacle if it is placed: (6,)."""
        changed = self.subscriber.read(now, WALL + now, TICK, depth_in_robot)
        if not changed:
            return None
        return np.concatenate([changed["ball"].position, changed["ball"].velocity])

    @property
    def refused(self) -> dict[str, int]:
        return dict(self.subscriber.counts.refused)


@pytest.fixture
def sender() -> Sender:
    return Sender()


def test_the_velocity_is_that_between_poses_and_continues_them(sender: Sender) -> None:
    assert sender.read(0.0) is None
    sender.put(0.0, (0.0, 0.0, 0.1))
    np.testing.assert_allclose(sender.read(0.0), [0.0, 0.0, 0.1, 0.0, 0.0, 0.0])
    sender.put(0.1, (0.02, 0.0, 0.1))
    # read 10 ms after it was made, for the end of the tick
    expected = [0.02 + 0.2 * (0.01 + TICK), 0.0, 0.1, 0.2, 0.0, 0.0]
    np.testing.assert_allclose(sender.read(0.11), expected, atol=1e-6)
    assert sender.read(0.12) is None, "the model has its velocity"
    assert sender.subscriber.counts.accepted == 2
    assert not sender.refused


def test_an_obstacle_that_would_appear_in_the_robot_is_refused_and_counted(sender: Sender) -> None:
    sender.put(0.0, (0.0, 0.0, -0.51))
    assert sender.read(0.0) is None
    assert sender.refused == {"not_plausible": 1}
    sender.put(0.02, (0.0, 0.0, -0.501))  # 1 mm: it touches
    assert sender.read(0.02) is not None
    sender.put(0.12, (0.0, 0.0, -0.53))  # it pushes its way in, as fast as it may
    assert sender.read(0.12) is not None
    sender.put(0.62, (0.0, 0.0, -0.6))  # after a silence it appears again
    sender.read(0.62)
    assert sender.refused == {"not_plausible": 2}


def test_a_stream_that_stops_leaves_the_obstacle_where_it_is_then(sender: Sender) -> None:
    sender.put(0.0, (0.0, 0.0, 0.1))
    sender.read(0.0)
    sender.put(0.1, (0.02, 0.0, 0.1))
    sender.read(0.1)
    assert sender.read(0.29) is None
    assert sender.subscriber.diagnostic(0.29).level is Level.OK
    expected = [0.02 + 0.2 * STREAM.timeout, 0.0, 0.1, 0.0, 0.0, 0.0]
    np.testing.assert_allclose(sender.read(0.31), expected, atol=1e-6)
    assert sender.read(0.33) is None
    said = sender.subscriber.diagnostic(0.33)
    assert said.level is Level.WARN
    assert "stand still: ball" in said.message
    assert said.values["stopped"] == "1"
    sender.put(1.0, (0.1, 0.0, 0.1))  # it may have moved meanwhile, its velocity is not known
    np.testing.assert_allclose(sender.read(1.0), [0.1, 0.0, 0.1, 0.0, 0.0, 0.0], atol=1e-9)
    assert sender.subscriber.diagnostic(1.0).values["silent"] == ""


def test_a_pose_without_a_time_was_made_when_it_arrived(sender: Sender) -> None:
    """Where that is not known either, it is as of now."""
    for x, now, arrived in ((0.0, 0.0, None), (0.01, 0.1, 0.05), (0.02, 0.2, 0.15)):
        at = None if arrived is None else Arrival(WALL + arrived)
        sender.samples.append(Sample(timeless(x), timestamp=at))
        found = sender.read(now)
        assert found is not None
    # 0.01 m in 0.1 s, read 50 ms after it arrived, for the end of the tick
    assert found[:1] == pytest.approx(0.02 + 0.1 * (0.05 + TICK), abs=1e-6)
    sender.samples.append(Sample(timeless(0.03), timestamp=Arrival(WALL + 0.25)))
    assert sender.read(0.25 + 1.1 * STREAM.timeout) is not None  # it stops
    assert sender.refused == {"too_old": 1}


def timeless(x: float) -> bytes:
    """A pose without a time."""
    return encode_effector("frame", "ball", EffectorMessage(0, "base", (x, 0.0, 0.1, *UPRIGHT)))


def test_many_small_jumps_in_a_tick_are_no_way_round_the_largest_speed(sender: Sender) -> None:
    """A pose may differ by noise from the last one; of those that come within a tick one counts."""
    sender.put(0.0, (0.0, 0.0, 0.1))
    sender.read(0.0)
    for k in range(1, 5):
        sender.put(1e-4 * k, (9e-5 * k, 0.0, 0.1))
    found = sender.read(0.01)
    assert found is None or np.linalg.norm(found[3:]) <= STREAM.largest_speed * (1.0 + 1e-9)
    assert found is None or found[0] < 2e-4 + STREAM.largest_speed * 0.1


@pytest.mark.parametrize(("times", "accepted"), [(0.95, 2), (1.05, 1)])
@pytest.mark.parametrize("turns", [False, True])
def test_an_obstacle_is_no_faster_than_it_may_be(
    sender: Sender, times: float, accepted: int, turns: bool
) -> None:
    """A tenth of a second after the first pose, at a share of the largest speed or spin."""
    sender.put(0.0, (0.0, 0.0, 0.1))
    sender.read(0.0)
    way, angle = times * 0.1 * STREAM.largest_speed, times * 0.1 * STREAM.largest_spin
    if turns:
        half = 0.5 * angle
        sender.put(0.1, (0.0, 0.0, 0.1), (float(np.cos(half)), 0.0, float(np.sin(half)), 0.0))
    else:
        sender.put(0.1, (way, 0.0, 0.1))
    sender.read(0.1)
    assert sender.subscriber.counts.accepted == accepted


nan = float("nan")
HOSTILE: dict[str, tuple[tuple[object, ...], str]] = {
    "not finite": ((0.05, (nan, 0.0, 0.0)), "not_finite"),
    "no rotation": ((0.05, (0.0, 0.0, 0.1), (2.0, 0.0, 0.0, 0.0)), "no_rotation"),
    "another frame": ((0.05, (0.0, 0.0, 0.1), UPRIGHT, "camera"), "wrong_frame"),
    "too old": ((-0.3, (0.0, 0.0, 0.1)), "too_old"),
    "not newer": ((0.0, (0.0, 0.0, 0.1)), "too_old"),
    "a jump": ((0.05, (0.1, 0.0, 0.1)), "not_plausible"),
    "a turn": ((0.05, (0.0, 0.0, 0.1), (0.0, 1.0, 0.0, 0.0)), "not_plausible"),
    "far away": ((0.05, (1e30, 0.0, 0.1)), "out_of_reach"),
}


@pytest.mark.parametrize("name", HOSTILE)
@pytest.mark.parametrize("json", [False, True])
def test_what_is_no_pose_is_refused_and_counted(sender: Sender, name: str, json: bool) -> None:
    sender.put(0.0, (0.0, 0.0, 0.1))
    sender.read(0.0)
    arguments, reason = HOSTILE[name]
    sender.put(*arguments, json=json)  # type: ignore[arg-type]
    assert sender.read(0.06) is None
    assert sum(sender.refused.values()) == 1
    if not (json and name == "not finite"):  # JSON has no such number
        assert sender.refused == {reason: 1}
    sender.put(0.1, (0.001, 0.0, 0.1))
    assert sender.read(0.1) is not None, "the next correct one counts"
    assert sender.subscriber.diagnostic(0.1).values["refused"] == "1"


def test_bytes_that_are_no_message_and_floods_cost_no_more_than_a_ring(sender: Sender) -> None:
    rng = np.random.default_rng(0)
    for size in (0, 3, 200, 20_000):
        sender.samples.append(Sample(rng.bytes(size)))
    for _ in range(10_000):
        sender.samples.append(Sample(rng.bytes(30)))
    assert sender.read(0.0) is None
    assert sum(sender.refused.values()) == OBSTACLE_RING
    for i in range(10_000):
        sender.put(1e-6 * i, (0.0, 0.0, 0.1))
    assert sender.read(0.02) is not None
    assert sender.subscriber.counts.accepted <= OBSTACLE_RING


def test_states_and_wrenches_come_back_as_they_were() -> None:
    rng = np.random.default_rng(1)
    pose = pose_at(*(rng.normal(size=n) for n in (3, 4, 3, 3)))
    found = decode_obstacle(encode_obstacle(ObstacleState(5, "base", "ball", pose)))
    assert isinstance(found, ObstacleState)
    assert (found.stamp, found.frame, found.name) == (5, "base", "ball")
    for name in ("position", "quaternion", "velocity", "spin"):
        np.testing.assert_allclose(getattr(found.pose, name), getattr(pose, name), atol=1e-14)
    wrench = rng.normal(size=6)
    np.testing.assert_array_equal(decode_wrench(encode_wrench(5, "base", wrench)), wrench)
    broken = pose_at([0.0, 0.0, 0.0])
    broken.position[0] = np.nan
    assert isinstance(
        decode_obstacle(encode_obstacle(ObstacleState(5, "", "b", broken))), Rejection
    )
    assert isinstance(decode_wrench(encode_wrench(5, "base", np.full(6, np.inf))), Rejection)
    assert isinstance(decode_obstacle(b"no message"), Rejection)
