"""Health of the loop: what left and what the model has, where the limiter made them differ."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.robots.bodies import beam_robot, box_mesh

from tauten.controller import Actuation, Controller
from tauten.model import cable_actuators
from tauten.service.node import Action, Clock, ControlLoop, LoopStatistics, Signals
from tauten.service.wire import (
    Cause,
    Diagnostic,
    Level,
    Mode,
    Rejection,
    RejectionReason,
    Tick,
    decode_health,
    encode_health,
)

SIZE = (0.1, 0.02, 0.02)
NAMES = ("cable",)


class Overloaded(Controller):
    """A controller whose model is under a load that its held cable carries."""

    def hold(self) -> Actuation:
        return replace(super().hold(), effort=np.array([157.0]))


def tick_of(action: Action) -> Tick:
    return Tick(
        stamp=1, frame="base", index=0, mode=action.mode, cause=action.cause, status="", goal=(),
        correction=(), target_stamp=0, lateness=0.0, latency=0.0, decide=0.0, step=0.0, slack=0.0,
        skipped=0, deepest_gap=0.0, complementarity=0.0, stationarity=0.0, extra_columns=0,
        clamped=action.actuation.clamped,
    )  # fmt: skip


def efforts(action: Action) -> Diagnostic:
    statistics = LoopStatistics(cable_actuators(NAMES))
    statistics.add(tick_of(action), action)
    found = statistics.diagnostics(Clock(0.02), [], None, {})
    return next(item for item in found if item.name == "tensions")


@pytest.mark.parametrize("overloaded", [False, True])
def test_health_has_the_tension_that_left_and_the_models(overloaded: bool) -> None:
    robot = beam_robot(box_mesh(SIZE, (6, 2, 2)), SIZE)
    loop = ControlLoop(Overloaded(robot) if overloaded else Controller(robot))
    action = loop.tick(None, Signals(target=False))
    assert (action.mode, action.cause) == (Mode.IDLE, Cause.NO_TARGET)
    largest = float(robot.limits.effort_max[0])
    health = efforts(action)
    if not overloaded:
        assert (health.level, health.message) == (Level.OK, "as in the model")
        return
    assert largest < 157.0
    assert action.actuation.effort.tolist() == [largest]
    assert action.actuation.clamped
    assert health.level is Level.WARN
    assert health.message == f"cable: {largest:.3g} N have left, the model has 157 N"
    assert health.values == {"cable_n": f"{largest:.4g}", "cable_model_n": "157"}


def test_a_level_that_does_not_exist_is_refused() -> None:
    payload = bytearray(encode_health(1, "r", [Diagnostic("x", Level.STALE, "", {})]))
    found = decode_health(bytes(payload))
    assert isinstance(found, dict)
    assert found["x"].level is Level.STALE
    place = payload.index(3, 20)  # the level is the first byte of the first status
    payload[place] = 7
    refused = decode_health(bytes(payload))
    assert isinstance(refused, Rejection)
    assert refused.reason is RejectionReason.MALFORMED
    assert refused.detail == "found level 7, allowed are 0, 1, 2, 3"
