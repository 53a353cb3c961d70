"""Each target is checked; only valid ones that are not too old become goals."""

from collections import deque
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
import pytest
from support.messages import Point, encode_point, point_json, point_layout

from tauten.model.signals import EffectorLayout
from tauten.service.codec.messages import MAX_PAYLOAD
from tauten.service.wire import (
    CDR,
    EFFECTOR_RING,
    JSON,
    EffectorMessage,
    EffectorSubscriber,
    encode_effector,
)
from tauten.service.wire.effector_subscriber import CLOCKS_AGREE

LAYOUT = point_layout(["tip", "middle"])
REST = np.array([0.0, 0.0, -0.1, 0.0, 0.1, 0.0])
HERE = REST + 0.01  # where the effectors are
WALL = 1.8e9  # s since the epoch


@dataclass(frozen=True)
class Arrival:
    """Time of arrival [s since the epoch], as Zenoh writes it into a sample."""

    seconds: float

    def get_time(self) -> datetime:
        return datetime.fromtimestamp(self.seconds, UTC)


@dataclass(frozen=True)
class Sample:
    payload: bytes
    encoding: str = CDR
    timestamp: Arrival | None = None


class Queue:
    """A ring of samples, as Zenoh's but filled by hand."""

    def __init__(self) -> None:
        self.samples: deque[Sample] = deque(maxlen=EFFECTOR_RING)

    def try_recv(self) -> Sample | None:
        return self.samples.popleft() if self.samples else None

    def put(
        self,
        xyz: tuple[float, float, float],
        frame: str = "base",
        stamp: int = 5,
        arrival: Arrival | None = None,
    ) -> None:
        payload = encode_point(Point(stamp, frame, xyz))
        self.samples.append(Sample(payload, timestamp=arrival))


@pytest.fixture
def queues() -> list[Queue]:
    return [Queue(), Queue()]


@pytest.fixture
def targets(queues: list[Queue]) -> EffectorSubscriber:
    return EffectorSubscriber(queues, "base", LAYOUT, REST, reach=0.3, timeout=0.5)


def test_there_is_no_goal_before_the_first_target(targets: EffectorSubscriber) -> None:
    assert targets.read(0.0, WALL) == []
    assert targets.latest(0.0, HERE) is None


def test_the_latest_target_is_used_and_other_effectors_keep_theirs(
    targets: EffectorSubscriber, queues: list[Queue]
) -> None:
    queues[0].put((0.01, 0.0, -0.1))
    queues[0].put((0.02, 0.0, -0.1), stamp=6)
    assert len(targets.read(1.0, WALL)) == 2
    np.testing.assert_array_equal(targets.latest(1.0, HERE), [0.02, 0.0, -0.1, *HERE[3:]])
    assert targets.stamp == 6
    assert targets.take_fresh()
    targets.read(1.1, WALL)
    assert targets.latest(1.1, HERE) is not None
    assert not targets.take_fresh()


def test_a_target_grows_old(targets: EffectorSubscriber, queues: list[Queue]) -> None:
    queues[1].put((0.0, 0.1, 0.01))
    targets.read(1.0, WALL)
    assert targets.latest(1.5, HERE) is not None
    assert targets.latest(1.51, HERE) is None
    queues[1].put((0.0, 0.1, 0.02))
    targets.read(2.0, WALL)
    assert targets.latest(2.0, HERE) is not None


def test_no_effector_keeps_the_target_of_another_alive(
    targets: EffectorSubscriber, queues: list[Queue]
) -> None:
    """A dead stream of one of two effectors: its last target is not followed for ever."""
    queues[0].put((0.05, 0.0, -0.1))
    for tick in range(50):
        now = 1.0 + 0.02 * tick
        queues[1].put((0.0, 0.12, 0.0))
        targets.read(now, WALL)
        first = 0.05 if now <= 1.5 else HERE[0]
        found = targets.latest(now, HERE)
        assert found is not None
        np.testing.assert_array_equal(found[[0, 4]], [first, 0.12])
        assert targets.outdated(now) == (() if now <= 1.5 else ("tip",))
        # and its rows are not corrected in a closed loop
        assert targets.followed(now).tolist() == 3 * [now <= 1.5] + 3 * [True]
    assert targets.latest(now + 0.6, HERE) is None
    queues[0].put((0.06, 0.0, -0.1))
    targets.read(now, WALL)
    assert targets.latest(now, HERE)[0] == 0.06  # type: ignore[index]
    assert targets.outdated(now) == ()


def test_an_empty_frame_is_the_robots(targets: EffectorSubscriber, queues: list[Queue]) -> None:
    queues[0].put((0.0, 0.0, -0.1), frame="")
    assert len(targets.read(0.0, WALL)) == 1


def test_json_is_read_too(targets: EffectorSubscriber, queues: list[Queue]) -> None:
    queues[0].samples.append(Sample(point_json(Point(0, "", (0.0, 0.0, -0.1))), JSON))
    assert len(targets.read(0.0, WALL)) == 1


def test_bad_targets_are_counted_by_reason_and_are_no_goal(
    targets: EffectorSubscriber, queues: list[Queue]
) -> None:
    queues[0].put((0.0, 0.0, -0.1), frame="map")
    queues[0].put((0.0, 0.0, -100.0))  # millimetres taken for metres
    queues[0].put((float("nan"), 0.0, 0.0))
    queues[0].samples.append(Sample(b"\x00\x01\x00\x00rubbish"))
    queues[0].samples.append(Sample(b"{", JSON))
    assert targets.read(0.0, WALL) == []
    assert targets.latest(0.0, HERE) is None
    assert targets.counts.accepted == 0
    assert targets.counts.refused == {
        "wrong_frame": 1,
        "out_of_reach": 1,
        "not_finite": 1,
        "malformed": 2,
    }
    shown = targets.counts.diagnostic("targets")
    assert shown.values["refused_malformed"] == "2"


def test_a_flood_costs_a_bounded_time_a_tick(
    targets: EffectorSubscriber, queues: list[Queue]
) -> None:
    for number in range(10 * EFFECTOR_RING):
        queues[0].put((1e-5 * number, 0.0, -0.1))
    assert len(targets.read(0.0, WALL)) == EFFECTOR_RING
    goal = targets.latest(0.0, HERE)
    assert goal is not None
    assert goal[0] == pytest.approx(1e-5 * (10 * EFFECTOR_RING - 1))  # the newest survives


def test_positions_are_complete_while_each_is_young(
    targets: EffectorSubscriber, queues: list[Queue]
) -> None:
    queues[0].put((0.01, 0.0, -0.1))
    targets.read(1.0, WALL)
    assert targets.complete(1.0) is None
    queues[1].put((0.0, 0.11, 0.0))
    targets.read(1.2, WALL)
    assert targets.fresh
    np.testing.assert_allclose(targets.complete(1.5), [0.01, 0.0, -0.1, 0.0, 0.11, 0.0])
    queues[1].put((0.0, 0.12, 0.0))
    targets.read(1.51, WALL)
    assert targets.complete(1.51) is None  # the first is too old by now


def test_a_payload_that_is_too_large_is_refused(
    targets: EffectorSubscriber, queues: list[Queue]
) -> None:
    queues[0].samples.append(Sample(bytes(MAX_PAYLOAD + 1)))
    assert targets.read(0.0, WALL) == []
    assert targets.counts.refused == {"too_large": 1}


def test_age_counts_from_arrival_and_not_from_when_the_loop_reads(
    targets: EffectorSubscriber, queues: list[Queue]
) -> None:
    """A loop that stood for a while reads targets that have waited for it."""
    queues[0].put((0.01, 0.0, -0.1), stamp=0, arrival=Arrival(WALL - 4.0))
    assert targets.read(1.0, WALL) == []
    assert targets.latest(1.0, HERE) is None
    assert targets.counts.refused == {"too_old": 1}
    queues[0].put((0.01, 0.0, -0.1), stamp=0, arrival=Arrival(WALL - 0.4))
    assert len(targets.read(1.0, WALL)) == 1
    assert targets.latest(1.09, HERE) is not None
    assert targets.latest(1.11, HERE) is None


def test_age_counts_from_the_header_where_clocks_agree(
    targets: EffectorSubscriber, queues: list[Queue]
) -> None:
    """A network that stood delivers targets that have just arrived and are old."""
    queues[0].put((0.01, 0.0, -0.1), stamp=int(1e9 * (WALL - 4.0)), arrival=Arrival(WALL))
    assert targets.read(1.0, WALL) == []
    assert "4 s ago, allowed are 0.5 s" in targets.counts.last_rejection
    queues[0].put((0.01, 0.0, -0.1), stamp=int(1e9 * (WALL - 0.4)), arrival=Arrival(WALL))
    targets.read(1.0, WALL)
    assert targets.latest(1.09, HERE) is not None
    assert targets.latest(1.11, HERE) is None


@pytest.mark.parametrize("off", [-3600.0, 3600.0, 1.0, -CLOCKS_AGREE - 1.0])
def test_times_of_clocks_that_do_not_agree_are_not_used_for_the_age(
    targets: EffectorSubscriber, queues: list[Queue], off: float
) -> None:
    made = int(1e9 * (WALL + off))
    queues[0].put((0.01, 0.0, -0.1), stamp=made, arrival=Arrival(WALL))
    assert len(targets.read(1.0, WALL)) == 1
    assert targets.latest(1.5, HERE) is not None
    assert targets.latest(1.51, HERE) is None


@pytest.mark.parametrize(("age", "accepted"), [(0.45, 1), (0.55, 0)])
def test_a_target_is_too_old_from_the_timeout_on(
    targets: EffectorSubscriber, queues: list[Queue], age: float, accepted: int
) -> None:
    queues[0].put((0.01, 0.0, -0.1), stamp=int(1e9 * (WALL - age)))
    assert len(targets.read(1.0, WALL)) == accepted


def test_the_oldest_of_all_effectors_counts_as_the_age(
    targets: EffectorSubscriber, queues: list[Queue]
) -> None:
    queues[0].put((0.01, 0.0, -0.1))
    targets.read(1.0, WALL)
    queues[1].put((0.0, 0.11, 0.0))
    targets.read(1.2, WALL)
    assert targets.oldest(1.3) == pytest.approx(0.3)


@pytest.mark.parametrize("delay", [0.0, 0.15])
def test_what_was_made_before_the_last_one_does_not_replace_it(
    queues: list[Queue], delay: float
) -> None:
    """Of several senders or ways through a network; from the timeout on another clock may have begun."""
    targets = EffectorSubscriber(queues, "base", LAYOUT, REST, 0.3, 0.5, delay=delay)
    for x, age, repeated in ((0.01, 0.2, 1), (0.03, 0.02, 2), (0.02, 0.1, 1)):
        for _ in range(repeated):
            queues[0].put((x, 0.0, -0.1), stamp=int(1e9 * (WALL - age)))
    assert len(targets.read(1.0, WALL)) == 3
    assert targets.counts.refused["too_old"] == 1
    assert "made 0.08 s before" in targets.counts.last_rejection
    found = targets.latest(1.3, HERE)
    assert found is not None and found[0] == 0.03
    queues[0].put((0.04, 0.0, -0.1), stamp=7)
    assert targets.read(1.4, WALL) == []
    queues[0].put((0.04, 0.0, -0.1), stamp=7)
    assert len(targets.read(1.6, WALL)) == 1
    queues[0].put((0.05, 0.0, -0.1), stamp=0)  # unknown
    assert len(targets.read(1.6, WALL)) == 1


def test_lines_between_targets_are_those_of_the_times_when_they_were_made(
    queues: list[Queue],
) -> None:
    """Two targets that arrive together were made 0.1 s apart: between them lies what was wanted then."""
    targets = EffectorSubscriber(queues, "base", LAYOUT, REST, 0.3, 0.5, delay=0.15)
    for age, x in ((0.2, 0.01), (0.1, 0.02)):
        queues[0].put((x, 0.0, -0.1), stamp=int(1e9 * (WALL - age)))
    targets.read(1.0, WALL)
    found = targets.latest(1.0, HERE)
    assert found is not None
    assert found[0] == pytest.approx(0.015, abs=1e-7)


@pytest.mark.parametrize(("volume", "accepted"), [(15.9e-6, 1), (16.1e-6, 0)])
def test_a_volume_is_out_of_reach_by_what_it_counts_in_metres(volume: float, accepted: int) -> None:
    """8 ml changed by 8 ml over a surface of 4 cm² count 2 cm, which are the reach here."""
    unit = np.array([8e-6 ** (-2.0 / 3.0)])
    layout = EffectorLayout(("air",), ("volume",), np.ones(1), unit, np.zeros(1, np.bool_))
    queue = Queue()
    targets = EffectorSubscriber([queue], "base", layout, np.array([8e-6]), 0.02, 0.5)
    message = EffectorMessage(0, "base", (volume,))
    queue.samples.append(Sample(encode_effector("volume", "air", message)))
    assert len(targets.read(1.0, WALL)) == accepted


@pytest.mark.parametrize(("value", "accepted"), [(-0.059, 1), (-0.061, 0), (0.019, 1), (0.021, 0)])
def test_a_function_of_another_package_may_be_negative(value: float, accepted: int) -> None:
    """As a height above a table; targets below it were refused."""
    one = np.ones(1)
    layout = EffectorLayout(("height",), ("function",), one, one, np.zeros(1, np.bool_))
    queue = Queue()
    targets = EffectorSubscriber([queue], "base", layout, np.array([-0.02]), 0.04, 0.5)
    payload = encode_effector("function", "height", EffectorMessage(0, "base", (value,)))
    queue.samples.append(Sample(payload))
    assert len(targets.read(1.0, WALL)) == accepted
