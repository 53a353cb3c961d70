"""The first picture: a robot half as high as the window, ground with its scale, base and obstacles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.processes import ROBOT, write_robot

from tauten.model import skin_of
from tauten.model.numerics import Array
from tauten.service.describing import describe
from tauten.service.frames import RobotLook
from tauten.service.setup import load_setup
from tauten.service.view import open_server
from tauten.service.view.picture import FIELD_OF_VIEW, PANEL, PRESETS, SHEET, RobotScene, camera_of
from tauten.service.view.picture.surroundings import cell_size, ground_height, length_text

BALL = """
[[obstacles]]
name = "ball"
shape = "sphere"
parameters = { centre = [0.05, 0.0, -0.1], radius = 0.02 }

[[contacts]]
against = "ball"
points = 10

[[surfaces]]
name = "below"
box = { lower = [-1.0, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }
normal = [0.0, 0.0, -1.0]
[[contacts]]
candidates = "below"
against = "ball"
points = 20
"""


def look_of(name: str | Path) -> RobotLook:
    """What a viewer knows of a robot."""
    setup = load_setup(name, basis="none")
    robot = setup.robot
    return RobotLook(describe(setup), skin_of(robot).geometry(robot, robot.rest(), None).vertices)


@pytest.fixture(scope="module")
def finger() -> RobotLook:
    """The shipped finger, which hangs from its base."""
    return look_of("finger")


def in_window(points: Array, position: Array, look_at: Array, aspect: float) -> Array:
    """Where points (m, 3) are in the window, from -1 to 1: (m, 2)."""
    out = (look_at - position) / np.linalg.norm(look_at - position)
    right = np.cross(out, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    away = points - position
    half = np.tan(0.5 * FIELD_OF_VIEW) * (away @ out)
    return np.stack([away @ right / (half * aspect), away @ np.cross(right, out) / half], axis=1)


@pytest.mark.parametrize("aspect", [1400 / 900, 390 / 844])
@pytest.mark.parametrize("preset", PRESETS)
def test_the_robot_is_whole_in_the_free_part_of_the_window(
    finger: RobotLook, preset: str, aspect: float
) -> None:
    camera = camera_of(finger, next(one for one in PRESETS if one == preset), aspect)
    shown = in_window(finger.vertices.astype(float), camera.position, camera.look_at, aspect)
    low, high = shown.min(axis=0), shown.max(axis=0)
    free = 2.0 * (1.0 - SHEET if aspect < 1.0 else 1.0)
    beside = 2.0 * (0.0 if aspect < 1.0 else PANEL / 1400.0)
    assert high[0] < 1.0 - beside, "not behind the panel"
    assert abs(low[0]) < 0.75
    assert abs(high[0]) < 0.75
    assert high[1] < 1.0
    assert low[1] > 1.0 - free, "not behind the panel of a phone"
    if preset == "front" and aspect > 1.0:
        assert (high[1] - low[1]) / 2.0 == pytest.approx(0.5, abs=0.06), "half the window"
        assert 0.5 * (low[0] + high[0]) == pytest.approx(-0.5 * beside, abs=0.05), (
            "beside the panel"
        )


def test_cells_of_the_ground_are_round_numbers_with_a_unit() -> None:
    assert cell_size(0.1022) == pytest.approx(0.01)
    assert cell_size(0.81) == pytest.approx(0.1)
    assert cell_size(0.4) == pytest.approx(0.05)
    assert cell_size(0.16) == pytest.approx(0.02)
    assert [length_text(one) for one in (0.01, 0.2, 2.0)] == ["10 mm", "200 mm", "2 m"]


def test_the_base_is_what_the_file_holds(finger: RobotLook) -> None:
    held = finger.vertices[finger.robot.surface.held]
    assert len(held)
    assert np.abs(held[:, 2]).max() == 0.0
    away = np.delete(finger.vertices, finger.robot.surface.held, axis=0)
    assert away[:, 2].max() < 0.0
    assert ground_height(finger) < finger.vertices[:, 2].min(), "it hangs above the ground"


def test_obstacles_are_drawn_once(tmp_path: Path) -> None:
    look = look_of(write_robot(tmp_path, ROBOT + BALL))
    (ball,) = look.robot.surface.obstacles
    away = np.linalg.norm(ball.outline[0] - [0.05, 0.0, -0.1], axis=1)
    assert away == pytest.approx(0.02)
    with open_server(0, "test") as (server, _):
        RobotScene(server, look, draggable=False)
        drawn = server.scene._handle_from_node_name
        assert "/obstacles/0" in drawn
        assert "/obstacles/1" not in drawn
        assert {"/ground", "/scale", "/base"} <= drawn.keys()


def test_the_ground_is_lines_just_under_a_floor_that_the_robot_lies_on(tmp_path: Path) -> None:
    """A grid is drawn in an order that depends on the view: it left white lines in obstacles."""
    look = look_of(write_robot(tmp_path))
    cell = cell_size(look.robot.size)
    with open_server(0, "test") as (server, _):
        RobotScene(server, look, draggable=False)
        ends = np.array(server.scene._handle_from_node_name["/ground"].points)  # type: ignore[attr-defined]
    below = ground_height(look) - ends[..., 2]
    assert 1e-3 * look.robot.size < below.min() <= below.max() < 5e-3 * look.robot.size
    assert len(np.unique(np.ptp(ends, axis=1).max(axis=1).round(6))) == 1  # as long as each other
    for lines in np.split(ends, 2):
        apart = np.linalg.norm(np.diff(lines[:, 0], axis=0), axis=1)
        np.testing.assert_allclose(apart, cell, rtol=1e-4)
