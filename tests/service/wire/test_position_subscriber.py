"""Targets are judged one by one; only good and young ones become goals."""

from collections import deque
from dataclasses import dataclass

import numpy as np
import pytest

from tauten.service.wire import (
    CDR,
    JSON,
    MAX_PAYLOAD,
    POSITION_RING,
    Point,
    PositionSubscriber,
    encode_point,
    point_json,
)

REST = np.array([[0.0, 0.0, -0.1], [0.0, 0.1, 0.0]])
HERE = REST + 0.01  # where the effectors are


@dataclass(frozen=True)
class Sample:
    payload: bytes
    encoding: str = CDR


class Queue:
    """A ring of samples, as Zenoh's but filled by hand."""

    def __init__(self) -> None:
        self.samples: deque[Sample] = deque(maxlen=POSITION_RING)

    def try_recv(self) -> Sample | None:
        return self.samples.popleft() if self.samples else None

    def put(self, xyz: tuple[float, float, float], frame: str = "base", stamp: int = 5) -> None:
        self.samples.append(Sample(encode_point(Point(stamp, frame, xyz))))


@pytest.fixture
def queues() -> list[Queue]:
    return [Queue(), Queue()]


@pytest.fixture
def inbox(queues: list[Queue]) -> PositionSubscriber:
    return PositionSubscriber(queues, "base", REST, reach=0.3, timeout=0.5)


def test_there_is_no_goal_before_the_first_target(inbox: PositionSubscriber) -> None:
    assert inbox.drain(0.0) == []
    assert inbox.goal(0.0, HERE) is None


def test_the_latest_target_wins_and_others_stay_where_they_are(
    inbox: PositionSubscriber, queues: list[Queue]
) -> None:
    queues[0].put((0.01, 0.0, -0.1))
    queues[0].put((0.02, 0.0, -0.1), stamp=6)
    assert len(inbox.drain(1.0)) == 2
    goal = inbox.goal(1.0, HERE)
    assert goal is not None
    np.testing.assert_array_equal(goal.positions, [[0.02, 0.0, -0.1], HERE[1]])
    assert (goal.stamp, goal.fresh) == (6, True)
    inbox.drain(1.1)
    again = inbox.goal(1.1, HERE)
    assert again is not None
    assert not again.fresh


def test_a_target_grows_old(inbox: PositionSubscriber, queues: list[Queue]) -> None:
    queues[1].put((0.0, 0.1, 0.01))
    inbox.drain(1.0)
    assert inbox.goal(1.5, HERE) is not None
    assert inbox.goal(1.51, HERE) is None
    queues[1].put((0.0, 0.1, 0.02))
    inbox.drain(2.0)
    assert inbox.goal(2.0, HERE) is not None


def test_an_empty_frame_is_the_robots(inbox: PositionSubscriber, queues: list[Queue]) -> None:
    queues[0].put((0.0, 0.0, -0.1), frame="")
    assert len(inbox.drain(0.0)) == 1


def test_json_is_read_too(inbox: PositionSubscriber, queues: list[Queue]) -> None:
    queues[0].samples.append(Sample(point_json(Point(0, "", (0.0, 0.0, -0.1))), JSON))
    assert len(inbox.drain(0.0)) == 1


def test_bad_targets_are_counted_by_reason_and_are_no_goal(
    inbox: PositionSubscriber, queues: list[Queue]
) -> None:
    queues[0].put((0.0, 0.0, -0.1), frame="map")
    queues[0].put((0.0, 0.0, -100.0))  # millimetres taken for metres
    queues[0].put((float("nan"), 0.0, 0.0))
    queues[0].samples.append(Sample(b"\x00\x01\x00\x00rubbish"))
    queues[0].samples.append(Sample(b"{", JSON))
    assert inbox.drain(0.0) == []
    assert inbox.goal(0.0, HERE) is None
    assert inbox.tally.accepted == 0
    assert inbox.tally.refused == {
        "wrong_frame": 1,
        "out_of_reach": 1,
        "not_finite": 1,
        "malformed": 2,
    }
    shown = inbox.tally.diagnostic("targets")
    assert shown.values["refused_malformed"] == "2"


def test_a_flood_costs_a_bounded_time_a_tick(
    inbox: PositionSubscriber, queues: list[Queue]
) -> None:
    for number in range(10 * POSITION_RING):
        queues[0].put((1e-5 * number, 0.0, -0.1))
    assert len(inbox.drain(0.0)) == POSITION_RING
    goal = inbox.goal(0.0, HERE)
    assert goal is not None
    assert goal.positions[0, 0] == pytest.approx(
        1e-5 * (10 * POSITION_RING - 1)
    )  # the newest survives


def test_positions_are_complete_while_each_is_young(
    inbox: PositionSubscriber, queues: list[Queue]
) -> None:
    queues[0].put((0.01, 0.0, -0.1))
    inbox.drain(1.0)
    assert inbox.complete(1.0) is None
    queues[1].put((0.0, 0.11, 0.0))
    inbox.drain(1.2)
    assert inbox.fresh
    np.testing.assert_allclose(inbox.complete(1.5), [[0.01, 0.0, -0.1], [0.0, 0.11, 0.0]])
    queues[1].put((0.0, 0.12, 0.0))
    inbox.drain(1.51)
    assert inbox.complete(1.51) is None  # the first is too old by now


def test_a_payload_that_is_too_large_is_refused(
    inbox: PositionSubscriber, queues: list[Queue]
) -> None:
    queues[0].samples.append(Sample(bytes(MAX_PAYLOAD + 1)))
    assert inbox.drain(0.0) == []
    assert inbox.tally.refused == {"too_large": 1}
