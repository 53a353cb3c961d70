"""Frames that are kept: found by their time, in bounded memory."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tauten.model import NO_CONTACTS, Geometry
from tauten.service.frames import FrameHistory, ViewFrame
from tauten.service.wire import Cause, Mode

SIZE = 120  # bytes of a frame


def frame(time: float) -> ViewFrame:
    """A frame of ten vertices."""
    vertices = np.zeros((10, 3), np.float32)
    geometry = Geometry(vertices, np.zeros((0, 2, 3), np.float32), NO_CONTACTS)
    zero = np.zeros(1)
    return ViewFrame(time, Mode.RUN, Cause.NONE, "", geometry, zero, zero, zero, zero, 0.0)


def filled(count: int, whole: bool, most: int) -> FrameHistory:
    """So many frames at times 0, 1, 2 …, where only some may be kept."""
    history = FrameHistory(whole, budget=most * SIZE)
    for time in range(count):
        history.add(frame(float(time)))
    return history


@given(st.integers(1, 300), st.integers(2, 40))
def test_the_end_is_kept(count: int, most: int) -> None:
    history = filled(count, whole=False, most=most)
    assert len(history) <= most
    assert history.last == count - 1
    times = [one.time for one in history.between(-1.0, count)]
    assert times == list(range(count))[-len(times) :]
    assert len(times) >= min(count, 0.9 * most - 1)


@given(st.integers(1, 300), st.integers(2, 40))
def test_the_whole_run_is_kept(count: int, most: int) -> None:
    history = filled(count, whole=True, most=most)
    assert len(history) <= most
    assert history.first == 0.0
    times = np.array([one.time for one in history.between(-1.0, count)])
    steps = np.diff(times)
    assert len(set(steps)) <= 1  # evenly thinned
    assert count - 1 - times[-1] < (steps[0] if len(steps) else count)


def test_frames_are_found_by_their_time() -> None:
    history = filled(10, whole=True, most=100)
    assert [history.at(time).time for time in (-5.0, 0.0, 3.4, 9.0, 50.0)] == [0, 0, 3, 9, 9]  # type: ignore[union-attr]
    assert FrameHistory(whole=True).at(1.0) is None
