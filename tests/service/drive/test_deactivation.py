"""A driver is deactivated to its end: a request to stop leaves it the time that this takes."""

from __future__ import annotations

import signal
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from tauten.model.numerics import Array
from tauten.service.describing import describe
from tauten.service.drive import Driver, Measured
from tauten.service.drive import loop as drive_loop
from tauten.service.drive.loop import DriveLoop
from tauten.service.plant import free_ports
from tauten.service.process import stop_on_signals
from tauten.service.setup import load_setup
from tauten.service.wire import Network, RobotDescription, Role, session_of

LONG = 30.0  # s, if nothing interrupts it


class Slow(Driver):
    """Hardware that takes its time to come to rest, and is asked to end meanwhile."""

    def __init__(self, seconds: float) -> None:
        self.seconds, self.at_rest = seconds, False

    def configure(self, robot: RobotDescription, options: Mapping[str, str]) -> None:
        pass

    def activate(self) -> None:
        pass

    def read(self) -> Measured:
        return Measured(*np.zeros((2, 2)))

    def write(self, position: Array, effort: Array) -> None:
        pass

    def deactivate(self) -> None:
        signal.raise_signal(signal.SIGINT)
        time.sleep(self.seconds)
        self.at_rest = True


@pytest.mark.parametrize("seconds", [0.8, LONG])
def test_a_deactivation_for_want_of_actuation_has_time_to_end(
    seconds: float, beam_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was interrupted like any call, and not called again: the robot kept what it had half let go."""
    monkeypatch.setattr(drive_loop, "_PATIENCE", 0.3)
    monkeypatch.setattr(drive_loop, "_LONGEST_DEACTIVATION", 1.5)
    driver, robot, network = Slow(seconds), describe(load_setup(beam_file)), Network(free_ports())
    with session_of(network, Role.PLANT, "beam", connected=False) as session:
        loop = DriveLoop(session, robot, driver, measure=False)
        loop.active, begin = True, time.monotonic()  # and nothing arrives
        with stop_on_signals() as stop:
            loop.run(stop)
    assert driver.at_rest == (seconds < LONG)
    assert time.monotonic() - begin < LONG
