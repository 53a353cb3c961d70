"""Robots stand as gravity says, and its direction is drawn; coordinates that are left free have no target."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.messages import effector
from support.processes import ROBOT, write_robot

from tauten.model import skin_of
from tauten.service.describing import describe
from tauten.service.frames import RobotLook
from tauten.service.frames.frame import distance_between, targets_of
from tauten.service.setup import load_setup
from tauten.service.view import open_server
from tauten.service.view.picture.cameras import sideways, upwards
from tauten.service.view.picture.legend import legend_html
from tauten.service.view.picture.scene import RobotScene

NONE = (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("gravity", "up"),
    [
        ((0.0, 0.0, -9.81), (0.0, 0.0, 1.0)),
        ((0.0, -9.81, 0.0), (0.0, 1.0, 0.0)),
        ((9.81, 0.0, 0.0), (-1.0, 0.0, 0.0)),
        (NONE, (0.0, 0.0, 1.0)),
    ],
)
def test_the_scene_is_turned_against_gravity(
    gravity: tuple[float, float, float],
    up: tuple[float, float, float],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    text = ROBOT.replace("gravity = [0.0, 0.0, 0.0]", f"gravity = {list(gravity)}")
    setup = load_setup(write_robot(tmp_path, text))
    robot = setup.robot
    look = RobotLook(describe(setup), skin_of(robot).geometry(robot, robot.rest(), None).vertices)
    assert look.robot.gravity == gravity
    turned: list[Any] = []
    arrows: dict[str, np.ndarray] = {}
    with open_server(0, "test") as (server, _):
        scene = server.scene
        add = scene.add_arrows

        def added(name: str, points: np.ndarray, *others: Any, **more: Any) -> Any:
            arrows[name] = points
            return add(name, points, *others, **more)

        monkeypatch.setattr(scene, "set_up_direction", turned.append)
        monkeypatch.setattr(scene, "add_arrows", added)
        RobotScene(server, look, draggable=False)
        camera = server.initial_camera
        seen = np.array(camera.look_at) - np.array(camera.position)
    assert turned == [pytest.approx(up)]
    assert abs(seen @ np.array(up)) < 0.3 * np.linalg.norm(seen), "from the side, a little above"
    assert seen @ np.array(up) < 0.0
    assert ("/gravity" in arrows) == ("gravity" in legend_html(look)) == (gravity != NONE)
    if gravity != NONE:
        along = arrows["/gravity"][0, 1] - arrows["/gravity"][0, 0]
        assert along / np.linalg.norm(along) == pytest.approx(-np.array(up), abs=1e-6)


def test_who_looks_from_the_front_has_right_and_back_at_right_angles() -> None:
    right, back = sideways(np.array(upwards((0.0, 0.0, -9.81))))
    assert (right.tolist(), back.tolist()) == ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    for gravity in ((0.0, 3.0, -9.0), (1.0, 0.0, 0.0), (-5.0, 5.0, 5.0)):
        up = np.array(upwards(gravity))
        right, back = sideways(up)
        assert np.stack([right, back, up]) @ np.stack([right, back, up]).T == pytest.approx(
            np.eye(3), abs=1e-12
        )
        assert np.cross(right, back) == pytest.approx(up)


def test_coordinates_that_are_left_free_have_no_target() -> None:
    """A plate that is to have a height: its target is above or below it, and so is its error."""
    frame = (0.0, 0.0, 0.01, 1.0, 0.0, 0.0, 0.0)
    looks = (effector("plate", "frame", *frame, weight=(0.0, 0.0, 1.0, 1.0, 1.0, 0.0)),)
    values, goal = np.array(frame), np.array([0.02, 0.03, 0.012, *frame[3:]])
    assert distance_between(looks, goal, values) == pytest.approx(0.002)
    assert targets_of(looks, goal, values)[0] == pytest.approx([0.0, 0.0, 0.012])
    nothing = np.full(7, np.nan)
    assert np.isnan(targets_of(looks, nothing, values)).all()
    trail = targets_of(looks, np.stack([goal, nothing]), np.stack([values, values]))
    assert trail[0, 0] == pytest.approx([0.0, 0.0, 0.012]) and np.isnan(trail[1]).all()
    turned = (effector("plate", "frame", *frame, weight=(0.0, 0.0, 0.0, 1.0, 1.0, 0.0)),)
    assert np.isnan(distance_between(turned, goal, values))
    assert np.isnan(targets_of(turned, goal, values)).all()
    with pytest.raises(ValueError, match="6 weights, found 3"):
        effector("plate", "frame", *frame, weight=(0.0, 0.0, 1.0))


def test_the_error_that_is_shown_is_the_largest_length() -> None:
    """Volumes have none in millimetres."""
    looks = effector("tip", "point", 0.1, 0.0, 0.0), effector("air", "volume", 8e-6)
    values, goal = np.array([0.1, 0.0, 0.0, 8e-6]), np.array([0.1, 0.001, 0.0, 9e-6])
    assert distance_between(looks, goal, values) == pytest.approx(0.001)
    assert np.isnan(distance_between(looks[1:], goal[3:], values[3:]))
    gap = (effector("gap", "distance", 0.02),)
    assert distance_between(gap, np.array([0.017]), np.array([0.02])) == pytest.approx(0.003)
