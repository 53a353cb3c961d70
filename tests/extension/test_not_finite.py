"""What an extension gives that is infinite or no number: a status, no warning, a log that can be replayed."""

from __future__ import annotations

import math
import time
import warnings
from dataclasses import replace
from itertools import product
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from support.messages import encode_point, tick_of
from support.nodes import point_at
from support.processes import ROBOT, write_robot
from support.robots.my_package import MUSCLE, SPREAD

from tauten.controller import Controller, Status, warm_controller
from tauten.model import load_robot
from tauten.service.codec.messages import POINT
from tauten.service.describing import log_metadata
from tauten.service.log import LogRecorder
from tauten.service.node import Clock, ControlLoop, Node, Signals
from tauten.service.node.clock import Beat
from tauten.service.node.statistics import LoopStatistics
from tauten.service.plant import free_ports
from tauten.service.replay import read_run, replay
from tauten.service.setup import load_setup
from tauten.service.wire import CDR, Cause, Keys, Mode, Network, Role, open_session


class Wrong:
    """A part of what the package's class gives at a point, which is another number while `given` is one."""

    def __init__(self, patch: pytest.MonkeyPatch, kind: type[object], part: str) -> None:
        self.given: float | None = None
        usual: Any = vars(kind)["at"]

        def either(one: object, y: object) -> object:
            found = usual(one, y)
            if self.given is None:
                return found
            return replace(found, **{part: self.given + 0.0 * getattr(found, part)})

        patch.setattr(kind, "at", either)


@pytest.mark.parametrize(
    ("kind", "part", "given"),
    [
        *product(["Spread"], ["values", "delta", "gradient", "position"], [math.inf, 1e200]),
        *product(["McKibben"], ["value", "gradient", "curvature"], [-math.inf]),
    ],
)
def test_infinite_numbers_are_a_status_and_no_warning(
    kind: str,
    part: str,
    given: float,
    package: ModuleType,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """numpy warned of them; with `python -W error` that ended the node."""
    wrong = Wrong(monkeypatch, getattr(package, kind), part)
    table = SPREAD if kind == "Spread" else MUSCLE
    robot = load_robot(write_robot(tmp_path, ROBOT + table))
    loop = ControlLoop(Controller(robot, "none"))
    statistics = LoopStatistics(robot.actuators, robot.effector_layout, robot.size)
    goal, limits, found = loop.controller.effector_values, robot.limits, []
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for given_now in (None, given, given, None, None):
            wrong.given = given_now
            for target in (goal, None):
                action = loop.tick(target, Signals(target is not None))
                loop.prepare()
                statistics.add(tick_of(action), action, loop.controller.effector_values)
                found.append(action.wanted.status)
                left = action.actuation
                assert (left.position >= limits.position_min).all()
                assert (left.position <= limits.position_max).all()
                assert (left.effort >= limits.effort_min).all()
                assert (left.effort <= limits.effort_max).all()
    if given != 1e200 and part != "curvature":
        assert Status.NOT_FINITE in found
        assert found[-2:] == [Status.OK, Status.OK]
    said = statistics.diagnostics(Clock(0.02), [], None, {})[1]
    assert math.isfinite(float(said.values["prediction_error_mm"]))


def test_a_goal_that_is_no_number_is_in_a_log_that_can_be_replayed(
    package: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An effector without a target has the model's value for a goal: logs were refused where that is none."""
    wrong = Wrong(monkeypatch, package.Spread, "values")
    file = write_robot(tmp_path, ROBOT + SPREAD)
    setup, port, log = load_setup(file, basis="none"), free_ports(), tmp_path / "run.mcap"
    controller = warm_controller(setup)
    recorder = LogRecorder(log, log_metadata(setup, controller.effector_values))
    inside = open_session(Network(port), Role.NODE, "beam", connected=False)
    outside = open_session(Network(port), Role.OTHER, "beam", connected=False)
    loop = ControlLoop(controller, settings=setup.service)
    node = Node(setup, loop, inside, recorder, closed_loop=False)
    clock, end = Clock(0.02, lambda: 0.0), time.monotonic() + 60.0
    target, (key,) = (
        encode_point(point_at(setup.robot, 0.01, stamp=0)),
        Keys("beam").targets(("tip",)),
    )

    def tick() -> None:
        assert time.monotonic() < end
        outside.put(key, target, encoding=f"{CDR};{POINT}")
        time.sleep(0.005)
        node.tick(clock, Beat(0, 0.0, 0.01, 0), shutdown=False)

    while loop.state.mode is not Mode.RUN:
        tick()
    for given in (math.nan, None):
        wrong.given = given
        for _ in range(3):
            tick()
    inside.close()  # type: ignore[no-untyped-call]
    outside.close()  # type: ignore[no-untyped-call]
    recorder.close()
    ticks = read_run(log).ticks
    assert any(one.status == "NOT_FINITE" and one.cause is Cause.UNUSABLE for one in ticks)
    assert ticks[-1].status == "OK"
    wrong.given = None
    assert replay(log, 1e-9, against=str(file)).same
