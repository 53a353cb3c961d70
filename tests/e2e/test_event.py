"""Ticks that come with their targets: answered at once, never closer than a period."""

from __future__ import annotations

import numpy as np
import pytest
from support.nodes import (
    PERIOD,
    check_limits,
    last_health,
    reached,
    recorded,
    send,
    streaming,
    wait_tip,
    whole,
)
from support.processes import Served

from tauten.model import Robot


@pytest.mark.parametrize("served", [("--event",)], indirect=True)
def test_targets_are_followed(served: Served, beam: Robot) -> None:
    goal = reached(beam, 0.003)
    with streaming(served, goal):
        wait_tip(served, "tauten/beam/effector", goal, 1e-3)
    assert served.process.end() == 0
    ticks, joints, _ = recorded(served.log, beam)
    assert whole(ticks)
    check_limits(joints, beam)
    assert sum(bool(np.isfinite(tick.latency)) for tick in ticks) > 5  # these had a new target


@pytest.mark.realtime
@pytest.mark.parametrize("served", [("--event",)], indirect=True)
def test_targets_are_answered_when_they_come(served: Served, beam: Robot) -> None:
    last_health(served)  # it has begun
    send(served, beam, 0.006, 3.0)
    assert served.process.end() == 0
    ticks, _, _ = recorded(served.log, beam)
    following = [tick for tick in ticks if tick.status]
    assert len(following) > 100
    apart = np.diff([1e-9 * tick.stamp for tick in following])  # s
    # the stamp is taken after the decision, whose time differs from tick to tick
    assert np.quantile(apart, 0.05) > 0.9 * PERIOD
    latency = [tick.latency for tick in following[20:] if np.isfinite(tick.latency)]
    assert np.median(latency) < 0.25 * PERIOD
    with_target = [tick for tick in following[20:] if np.isfinite(tick.latency)]
    assert len(with_target) > 0.9 * len(following[20:])
