"""Targets of a path that ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import zenoh
from support.messages import Point, decode_point
from support.nodes import answering
from support.processes import write_robot

from tauten.service.describing import describe
from tauten.service.plant import StreamSettings, TargetPath, free_ports, stream
from tauten.service.process import StopFlag
from tauten.service.setup import load_setup
from tauten.service.wire import CDR, Keys, Network


@pytest.mark.parametrize("end", [0.3, 0.33])
def test_the_last_target_is_the_end_of_the_path(end: float, tmp_path: Path) -> None:
    """Three periods of 0.1 s are more than 0.3 s in floating point, and 0.33 s is between two targets."""
    robot, port = describe(load_setup(write_robot(tmp_path))), free_ports()
    path = TargetPath(np.array([0.0, end]), np.array([[0.1, 0.0, 0.0], [0.1, 0.0, 0.01]]), False)
    settings = StreamSettings(rate=10.0, duration=None, json=False, effector=0, await_plant=False)
    with answering(robot, port) as session:
        key = Keys("beam").targets(robot.effector_names)[0]
        seen = session.declare_subscriber(key, zenoh.handlers.FifoChannel(100))
        count = stream(robot, path, settings, Network(port), StopFlag())
        points = [decode_point(bytes(seen.recv().payload), CDR) for _ in range(count)]
    last = points[-1]
    assert isinstance(last, Point)
    assert last.xyz == pytest.approx((0.1, 0.0, 0.01))
