"""One viewer for the tests of a file that only have something refused."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from support.viewers import Shown, showing, wait_until

from tauten.model import Robot
from tauten.service.frames import SimulatedRobot
from tauten.service.setup import load_setup


@pytest.fixture(scope="module")
def one_viewer(beam_file: Path, beam: Robot) -> Iterator[Shown]:
    """The viewer of all tests that only have something refused."""
    setups = [load_setup(beam_file, rate=20.0) for _ in range(2)]
    with showing(SimulatedRobot(*setups)) as found:
        yield found


@pytest.fixture
def refusing(one_viewer: Shown) -> Shown:
    """It, without a browser and with nothing refused so far."""
    assert wait_until(lambda: one_viewer.guard.browsers == 0)
    one_viewer.guard.refused.clear()
    return one_viewer
