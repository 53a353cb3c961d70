"""A cable drawn by clicks in a real browser and saved to the robot file."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from support.browsers import on_page, page_of
from support.viewers import showing, wait_until

from tauten.model import Robot, load_robot
from tauten.service.frames import SimulatedRobot
from tauten.service.setup import load_setup


@pytest.mark.slow
def test_a_cable_is_drawn_by_clicks_and_saved(beam_file: Path, beam: Robot, tmp_path: Path) -> None:
    file = Path(shutil.copytree(beam_file.parent, tmp_path / "own")) / beam_file.name
    text = file.read_text(encoding="utf-8")
    with (
        showing(SimulatedRobot(load_setup(file), load_setup(file)), file) as shown,
        page_of(shown.origin, "Operate") as page,
    ):
        camera = shown.server.initial_camera
        page.get_by_text("New cable").first.click()
        draw = page.get_by_label("draw").first
        draw.wait_for()

        def drawing() -> bool:
            """Switch *draw* on: a click while the folder opens misses it."""
            if not draw.is_checked():
                draw.click(force=True)
            return wait_until(lambda: shown.session._panel.draws, 3.0)

        assert wait_until(drawing, 60.0)

        def count() -> int:
            return len(shown.session.cable or ())

        def clicked(point: list[float]) -> bool:
            """Click a point of the skin; pages take clicks only once they have drawn it."""
            before = count()
            page.mouse.click(*on_page(np.array(point), camera.position, camera.look_at))
            return wait_until(lambda: count() > before, 20.0)

        front = 0.0  # the face y = 0 looks at the camera
        assert wait_until(lambda: clicked([0.02, front, 0.01]), 100.0)
        assert clicked([0.05, front, 0.006])
        assert clicked([0.09, front, 0.013])
        assert count() == 3
        page.get_by_role("button", name="save cable").click()
        assert wait_until(lambda: file.read_text(encoding="utf-8") != text, 60.0)
        page.get_by_text("is saved to").wait_for(timeout=60_000)
    assert file.read_text(encoding="utf-8").startswith(text)
    robot = load_robot(file)
    assert robot.actuators.names[-1] == "new_cable"
    ends = robot.actuator_segments(robot.rest())[robot.actuator_set.segment_owners == robot.n_a - 1]
    found = [ends[0, 0], *ends[:, 1]]
    for point, expected in zip(found, ([0.02, 0.01], [0.05, 0.006], [0.09, 0.013]), strict=True):
        assert point[[0, 2]] == pytest.approx(expected, abs=2e-3)  # about two pixels
        assert point[1] == pytest.approx(front, abs=1e-4)
