"""The viewer on a phone, which holds its window upright."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from support.browsers import on_page, page_of
from support.viewers import showing, wait_until

from tauten.model import Robot
from tauten.service.frames import SimulatedRobot
from tauten.service.setup import load_setup
from tauten.service.view.picture import SHEET

PHONE = (390, 844)


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
