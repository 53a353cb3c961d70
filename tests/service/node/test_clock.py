"""The clock keeps its grid: late beats are counted, lost periods skipped, waiting for targets moves it."""

import time
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tauten.controller import warm_controller
from tauten.service.node import Clock, ControlLoop, Node, punctual_clock
from tauten.service.node import node as node_module
from tauten.service.plant import free_ports
from tauten.service.process import StopFlag
from tauten.service.setup import load_setup
from tauten.service.wire import Cause, Mode, Network, Role, session_of


class Hand:
    """A clock that advances by explicit calls only."""

    def __init__(self) -> None:
        self.time = 100.0

    def now(self) -> float:
        return self.time

    def sleep(self, seconds: float) -> None:
        self.time += seconds


@pytest.fixture
def hand() -> Hand:
    return Hand()


def test_beats_are_on_the_grid(hand: Hand) -> None:
    clock = Clock(0.5, hand.now, hand.sleep)
    for index in range(1, 5):
        hand.time += 0.125  # work
        beat = clock.wait()
        assert (beat.index, beat.lateness, beat.slack, beat.skipped) == (index, 0.0, 0.375, 0)
        assert hand.time == 100.0 + 0.5 * index
    assert (clock.missed, clock.skipped) == (0, 0)


def test_an_overrun_makes_the_next_beat_late_but_not_the_one_after(hand: Hand) -> None:
    clock = Clock(0.5, hand.now, hand.sleep)
    clock.wait()
    hand.time += 0.75
    late = clock.wait()
    assert (late.index, late.lateness, late.slack, late.skipped) == (2, 0.25, -0.25, 0)
    assert clock.wait().index == 3
    assert hand.time == 101.5
    assert (clock.missed, clock.skipped) == (1, 0)


def test_lost_periods_are_skipped_not_queued(hand: Hand) -> None:
    clock = Clock(0.5, hand.now, hand.sleep)
    clock.wait()
    hand.time += 1.75  # three beats were due
    beat = clock.wait()
    assert (beat.index, beat.skipped) == (4, 2)
    assert beat.lateness == 0.25
    assert clock.wait().index == 5
    assert hand.time == 102.5
    assert (clock.missed, clock.skipped) == (1, 2)


def test_a_thread_that_is_woken_up_late_skips_what_it_slept_through(hand: Hand) -> None:
    """It ticked twice at once, first for a target as of when the first beat was due, however old that was."""
    slept = [1.75, 0.0]
    clock = Clock(0.5, hand.now, lambda seconds: hand.sleep(seconds + slept.pop(0)))
    beat = clock.wait()
    assert (beat.index, beat.lateness, beat.slack, beat.skipped) == (4, 0.25, -1.5, 3)
    beat = clock.wait()
    assert (beat.index, beat.lateness, beat.slack, beat.skipped) == (5, 0.0, 0.25, 0)
    assert hand.time == 102.5
    assert (clock.missed, clock.skipped) == (1, 3)


def test_a_beat_is_never_early(hand: Hand) -> None:
    def now() -> float:
        hand.time += 1e-6  # watching takes time, or it would never end
        return hand.time

    for awake in (False, True):
        begin, clock = hand.time, Clock(0.5, now, hand.sleep, awake=awake)
        for index in range(1, 4):
            clock.wait(lambda: None)
            assert begin + 0.5 * index <= hand.time < begin + 0.5 * index + 1e-4


def test_there_is_time_for_something_before_a_beat(hand: Hand) -> None:
    clock, seen = Clock(0.5, hand.now, hand.sleep), []

    def look() -> None:
        seen.append(hand.time)
        hand.time += 0.0001

    def idle() -> None:
        seen.append(hand.time)
        hand.time += 0.0002

    beat = clock.wait(look, idle)
    assert seen == pytest.approx([100.4988, 100.4989])
    # the first is work of the period that ends, the second is not
    assert (beat.lateness, beat.slack) == (pytest.approx(0.0, abs=1e-9), pytest.approx(0.4999))
    hand.time = 100.999  # too little left
    clock.wait(look, idle)
    assert len(seen) == 2
    assert clock.missed == 0


def test_short_periods_look_just_before_the_beat_when_awake(hand: Hand) -> None:
    def now() -> float:
        hand.time += 1e-6  # watching takes time, or it would never end
        return hand.time

    clock, seen = Clock(0.001, now, hand.sleep, awake=True), []
    for _ in range(50):
        clock.wait(lambda: seen.append(clock.remaining), lambda: seen.append(np.inf))
    assert len(seen) == 50
    assert seen == pytest.approx([1.5e-4] * 50, abs=5e-6)


def test_what_is_done_just_before_the_beat_is_work_and_may_miss_it(hand: Hand) -> None:
    def now() -> float:
        hand.time += 1e-6  # watching takes time, or it would never end
        return hand.time

    def look() -> None:
        hand.time += took

    clock, took = Clock(0.001, now, hand.sleep, awake=True), 1e-4
    beat = clock.wait(look)
    assert beat.slack == pytest.approx(0.0009, abs=1e-5)
    assert (beat.lateness, clock.missed) == (pytest.approx(0.0, abs=5e-6), 0)
    took = 1.3e-3  # the time left and more
    beat = clock.wait(look)
    assert beat.slack < 0.0
    assert clock.missed == 1


def test_short_periods_have_no_time_for_anything_when_asleep(hand: Hand) -> None:
    clock, seen = Clock(0.001, hand.now, hand.sleep), []
    for _ in range(5):
        clock.wait(lambda: seen.append(hand.time))
    assert not seen


@pytest.mark.realtime
def test_the_last_moment_is_not_slept_through() -> None:
    clock, late = punctual_clock(0.002), []
    for _ in range(50):
        late.append(clock.wait().lateness)
    assert np.median(late) < 2e-5


@pytest.mark.realtime
def test_real_beats_do_not_drift() -> None:
    clock = Clock(0.005)
    start = time.monotonic()
    for _ in range(100):
        beat = clock.wait()
    # whatever the scheduler did to single beats, the grid is where it was
    assert time.monotonic() - start == pytest.approx(beat.index * 0.005 + beat.lateness, abs=0.004)
    assert beat.index == 100 + clock.skipped


def test_a_delayed_beat_moves_the_grid(hand: Hand) -> None:
    clock = Clock(0.5, hand.now, hand.sleep)
    clock.wait()
    hand.time += 0.125  # waited for a target
    clock.delay(0.125)
    beat = clock.wait()
    assert (beat.lateness, beat.slack) == (0.0, 0.5)
    assert hand.time == 101.125
    assert clock.missed == 0


@pytest.mark.parametrize("arrive", [True, False])
def test_ticks_with_their_targets_are_never_closer_than_a_period(
    arrive: bool, beam_file: Path, hand: Hand, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The one after a late tick came on the old grid, 0.4 of a period after it: winches turned too fast."""
    setup, stop = load_setup(beam_file), StopFlag()
    period, work, begun = setup.robot.h, [0.1, 1.6, 0.1, 0.1, 3.2, 0.1, 0.1], list[float]()

    def tick(*_: object, **__: object) -> None:
        begun.append(hand.time)
        hand.time += work[len(begun) - 1] * period
        stop.requested = len(begun) == len(work)

    loop = ControlLoop(warm_controller(setup), settings=setup.service)
    monkeypatch.setattr(
        node_module, "punctual_clock", lambda period: Clock(period, hand.now, hand.sleep)
    )
    with session_of(Network(free_ports()), Role.NODE, "beam", connected=False) as session:
        node = Node(setup, loop, session, None, closed_loop=False)
        loop.set_mode(Mode.RUN, Cause.NONE)
        monkeypatch.setattr(
            node_module, "time", SimpleNamespace(monotonic=hand.now, sleep=hand.sleep)
        )
        monkeypatch.setattr(node._inputs, "read_targets", lambda *_: arrive)
        monkeypatch.setattr(node, "tick", tick)
        monkeypatch.setattr(node, "_release", lambda *_: None)
        node.run(stop, event=True)
    apart = [after - before for before, after in pairwise(begun)]
    assert min(apart) > (1.0 - 1e-9) * period
    assert max(apart) < 3.2 * period + 0.5 * period + 1e-3  # no longer than work and waiting take
