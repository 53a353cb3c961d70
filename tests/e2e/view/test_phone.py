"""The viewer on a phone, which holds its window upright, and in other windows that are not wide."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from support.browsers import on_page, page_of
from support.viewers import showing, wait_until

from tauten.model import Robot
from tauten.service.frames import SimulatedRobot
from tauten.service.setup import load_setup
from tauten.service.view.picture import PANEL, SHEET

PHONE = (390, 844)


@pytest.mark.long
def test_a_phone_shows_robot_and_target_above_the_panel(beam_file: Path, beam: Robot) -> None:
    setup = load_setup(beam_file, rate=10.0)
    with (
        showing(SimulatedRobot(setup, load_setup(beam_file, rate=10.0))) as shown,
        page_of(shown.origin, "Operate", PHONE) as page,
    ):
        top = page.get_by_text("Operate").first.bounding_box()
        assert top is not None
        assert top["y"] > 0.5 * PHONE[1]
        (client,) = shown.server.get_clients().values()
        points = np.concatenate([beam.points(beam.rest()), beam.effector(beam.rest())])

        def above() -> bool:
            """Whether all is in the window and above the panel."""
            camera = client.camera
            places = [on_page(one, camera.position, camera.look_at, PHONE) for one in points]
            x, y = np.array(places).T
            free = (1.0 - SHEET) * PHONE[1]
            return bool(x.min() > 0 and x.max() < PHONE[0] and y.min() > 0 and y.max() < free)

        assert wait_until(above)


@pytest.mark.slow
def test_a_robot_is_as_large_in_a_window_that_is_not_wide(beam_file: Path, beam: Robot) -> None:
    """It was so large as in a wide one, and ended under the panel."""
    size = (640, 700)
    free = size[0] - PANEL
    setup = load_setup(beam_file, rate=10.0)
    with (
        showing(SimulatedRobot(setup, load_setup(beam_file, rate=10.0))) as shown,
        page_of(shown.origin, "Operate", size),
    ):
        (client,) = shown.server.get_clients().values()
        points = beam.points(beam.rest())

        def beside() -> bool:
            """Whether it is beside the panel, and nearly half as wide as what is free."""
            camera = client.camera
            places = [on_page(one, camera.position, camera.look_at, size)[0] for one in points]
            inside = min(places) > 0.0 and max(places) < free
            return inside and 0.35 < (max(places) - min(places)) / free < 0.5

        assert wait_until(beside)
        time.sleep(1.0)
        assert beside(), "and stays there"
