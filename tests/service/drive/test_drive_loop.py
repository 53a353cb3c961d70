"""What reaches a driver is finite, of its robot and within limits; where nothing comes it is deactivated."""

from __future__ import annotations

import math
import signal
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.nodes import answering

from tauten.model.numerics import Array
from tauten.service.describing import describe
from tauten.service.drive import Driver, DriverError, Measured
from tauten.service.drive import loop as drive_loop
from tauten.service.drive.loop import DriveLoop
from tauten.service.node import Clock
from tauten.service.plant import free_ports
from tauten.service.process import stop_on_signals
from tauten.service.setup import load_setup
from tauten.service.wire import (
    JOINTS,
    Joints,
    Keys,
    Network,
    Publisher,
    RobotDescription,
    Role,
    encode_joints,
    session_of,
)

NAMES, ACTUATION = ("lower", "upper"), Keys("beam").actuation
SILENCE = 0.2  # s: ten periods of the robot
LONG = 30.0  # s, if nothing interrupts it


class Winches(Driver):
    """Hardware that remembers what it was told."""

    def __init__(self) -> None:
        self.calls: list[str] = []
        self.written: list[tuple[Array, Array]] = []

    def configure(self, robot: RobotDescription, options: Mapping[str, str]) -> None:
        pass

    def activate(self) -> None:
        self.calls.append("activate")

    def read(self) -> Measured:
        return Measured(*np.zeros((2, 2)))

    def write(self, position: Array, effort: Array) -> None:
        self.written.append((position, effort))

    def deactivate(self) -> None:
        self.calls.append("deactivate")


class SlowWinches(Winches):
    """Hardware that takes its time to come to rest, and is asked to end meanwhile."""

    def __init__(self, seconds: float) -> None:
        super().__init__()
        self.seconds, self.at_rest = seconds, False

    def deactivate(self) -> None:
        signal.raise_signal(signal.SIGINT)
        time.sleep(self.seconds)
        self.at_rest = True


@pytest.fixture
def robot(beam_file: Path) -> RobotDescription:
    return describe(load_setup(beam_file))


def test_only_what_is_within_the_limits_of_its_robot_reaches_a_driver(
    robot: RobotDescription,
) -> None:
    """Of positions and of efforts; what has other names, or is not finite, is not written at all."""
    driver, port, clock = Winches(), free_ports(), Clock(0.02, lambda: 0.0)
    least = [one.effort[0] for one in robot.actuators]
    most = [one.effort[1] for one in robot.actuators]
    nothing, end = (0.0, 0.0), time.monotonic() + 60.0
    sent = [
        (("upper", "lower"), (0.005, 0.0), nothing),
        (NAMES, (0.005, math.nan), nothing),
        (NAMES, nothing, (math.inf, 0.0)),
        (NAMES, (0.001, 0.002), (1e3, -1e3)),
        (NAMES, (-1.0, 1.0), (-1e3, 1e3)),
    ]
    with (
        answering(robot, port) as node,
        session_of(Network(port), Role.PLANT, "beam", connected=False) as session,
    ):
        loop = DriveLoop(session, robot, driver, measure=False)
        publisher = Publisher(node, ACTUATION, JOINTS)
        while not publisher.has_subscribers:
            assert time.monotonic() < end
            time.sleep(0.01)
        for number, (names, position, effort) in enumerate(sent, 1):
            publisher.put(encode_joints(Joints(0, robot.frame, names, position, effort)))
            while loop._counts.accepted + loop._counts.refused.total() < number:
                assert time.monotonic() < end
                time.sleep(0.01)
                loop.tick(clock)
    (one, other), limits = driver.written, np.array([a.position for a in robot.actuators])
    np.testing.assert_array_equal(one, [[0.001, 0.002], [most[0], least[1]]])
    np.testing.assert_array_equal(other, [[limits[0, 0], limits[1, 1]], [least[0], most[1]]])
    assert driver.calls == ["activate"]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"facts": None}, "facts of type NoneType, expected Mapping"),
        ({"warning": np.zeros(2)}, "warning of type ndarray, expected str"),
    ],
)
def test_facts_and_warnings_that_are_none_are_named(
    given: dict[str, Any], said: str, robot: RobotDescription
) -> None:
    """Each was a traceback from the report of the loop's health."""
    driver, network = Winches(), Network(free_ports())
    driver.read = lambda: Measured(*np.zeros((2, 2)), **given)  # type: ignore[method-assign]
    with session_of(network, Role.PLANT, "beam", connected=False) as session:
        loop = DriveLoop(session, robot, driver, measure=False)
        with pytest.raises(DriverError, match=f"the driver of beam fails: its read.. gives {said}"):
            loop.tick(Clock(0.02, lambda: 0.0))


def test_a_driver_is_deactivated_when_nothing_has_arrived_for_ten_periods(
    robot: RobotDescription,
) -> None:
    driver, clock, network = Winches(), Clock(0.02, lambda: 0.0), Network(free_ports())
    with session_of(network, Role.PLANT, "beam", connected=False) as session:
        loop = DriveLoop(session, robot, driver, measure=False)
        loop.tick(clock)
        assert driver.calls == []  # it was never active
        loop.active, loop._heard = True, time.monotonic()
        loop.tick(clock)
        assert driver.calls == []
        loop._heard = time.monotonic() - 1.01 * SILENCE
        loop.tick(clock)
        loop.tick(clock)
    assert driver.calls == ["deactivate"]
    assert not loop.active


@pytest.mark.parametrize("seconds", [0.8, LONG])
def test_a_deactivation_for_want_of_actuation_has_time_to_end(
    seconds: float, robot: RobotDescription, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was interrupted like any call, and not called again: the robot kept what it had half let go."""
    monkeypatch.setattr(drive_loop, "_PATIENCE", 0.3)
    monkeypatch.setattr(drive_loop, "_LONGEST_DEACTIVATION", 1.5)
    driver, network = SlowWinches(seconds), Network(free_ports())
    with session_of(network, Role.PLANT, "beam", connected=False) as session:
        loop = DriveLoop(session, robot, driver, measure=False)
        loop.active, begin = True, time.monotonic()  # and nothing arrives
        with stop_on_signals() as stop:
            loop.run(stop)
    assert driver.at_rest == (seconds < LONG)
    assert time.monotonic() - begin < LONG
