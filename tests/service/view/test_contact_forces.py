"""Forces in the picture: cones of friction, what slides, how far the others are from it, and efforts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tauten.model import NO_CONTACTS, PushingContacts, skin_of
from tauten.service.describing import describe
from tauten.service.frames import RobotLook, SimulatedRobot
from tauten.service.setup import load_setup
from tauten.service.view import open_server
from tauten.service.view.picture import RobotScene
from tauten.service.view.picture.cameras import Camera
from tauten.service.view.picture.forces import (
    ForceNumbers,
    contact_numbers,
    friction_cones,
    stacked,
)

UP = [0.0, 0.0, 1.0]
# sticks with 0.2 N to slip, slides, is at the border, and has no friction; μ = 0.5 of the first three
CONTACTS = PushingContacts(
    points=np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]], np.float32),
    forces=np.array([[0.3, 0, 1], [0, 0.5, 1], [0.5, 0, 1], [0, 0, 2]], np.float32),
    normals=np.array([UP] * 4, np.float32),
    sliding=np.array([False, True, False, True]),
    margin=np.array([0.2, 0.0, 1e-9, 0.0], np.float32),
)


def test_the_coefficient_follows_from_force_and_margin() -> None:
    np.testing.assert_allclose(CONTACTS.friction, [0.5, 0.5, 0.5, 0.0], atol=1e-6)
    assert len(NO_CONTACTS.friction) == 0


def test_numbers_say_how_far_a_contact_is_from_slipping() -> None:
    texts = [text for text, _ in contact_numbers(CONTACTS, [0, 1, 2, 3]).values()]
    assert texts == ["1 N, 0.2 N to slip", "1.1 N, slides", "1.1 N, about to slip", "2 N"]


def test_cones_contain_the_arrows_of_forces_and_touch_those_that_slide() -> None:
    height = 0.1
    vertices, triangles = friction_cones(CONTACTS, [0, 1], height)
    assert triangles.max() < len(vertices)
    assert len(friction_cones(CONTACTS, [2], height)[0]) == len(vertices)
    for place in (0, 1):
        cone = vertices[17 * place : 17 * (place + 1)] - CONTACTS.points[place]
        assert not cone[0].any()  # its tip is the contact point
        np.testing.assert_allclose(cone[1:, 2], -height, atol=1e-6)
        widths = np.linalg.norm(cone[1:, :2], axis=1)
        np.testing.assert_allclose(widths, 0.5 * height, rtol=1e-5)
        tail = -CONTACTS.forces[place] / CONTACTS.forces[place, 2] * height
        reach = np.linalg.norm(tail[:2]) / widths[0]
        assert reach == pytest.approx((0.6, 1.0)[place], rel=1e-5)


@pytest.mark.long
def test_what_slides_has_another_colour() -> None:
    setup = load_setup("finger", basis="none")
    robot = setup.robot
    vertices = skin_of(robot).geometry(robot, robot.rest(), None).vertices
    with open_server(0, "test") as (server, _):
        scene = RobotScene(server, RobotLook(describe(setup), vertices), draggable=False)
        scene._draw_contacts(CONTACTS)
        drawn = server.scene._handle_from_node_name
        for name, count in (("/contacts", 3), ("/contacts_that_slide", 1)):
            assert len(drawn[name].points) == count  # type: ignore[attr-defined]
        scene._draw_contacts(NO_CONTACTS)
        assert not drawn["/contacts"].visible and not drawn["/contacts_that_slide"].visible


def test_numbers_do_not_cover_each_other() -> None:
    """Those of cables beside and behind each other were not to be read; one that is alone stays."""
    camera, up = Camera(np.array([0.0, -2.0, 1.0]), np.zeros(3)), np.array(UP)
    places = np.array([[0.0, 0, 0], [0.01, 0, 0.001], [0, 0.1, -0.05], [0.5, 0, 0], [0, 0, 0.9]])
    found = stacked(places, camera, up, 1.0)
    np.testing.assert_array_equal(found[[3, 4]], places[[3, 4]])
    out = camera.position / np.linalg.norm(camera.position)
    y = np.cross(out, np.cross(up, out))
    y /= np.linalg.norm(y)
    seen = found @ y / ((camera.position - found) @ out)
    assert (np.diff(np.sort(seen[:3])) * np.linalg.norm(camera.position) > 0.034).all()
    assert np.linalg.norm(found - places, axis=1).max() < 0.08
    np.testing.assert_allclose(stacked(found, camera, up, 1.0), found, atol=1e-12)


def test_slack_cables_have_no_number(beam_file: Path) -> None:
    """Those of a trunk with eight cables covered each other after a stop."""
    source = SimulatedRobot(*(load_setup(beam_file) for _ in range(2)))
    frame = source.advance(source.look.robot.rest, True)
    assert frame is not None
    np.testing.assert_array_equal(frame.decided, source._loop.controller.actuation.effort)
    with open_server(0, "test") as (server, _):
        shown = ForceNumbers(server.scene, source.look)
        for efforts, expected in (((3.0, 0.1), {"lower"}), ((3.0, 4.0), {"lower", "upper"})):
            shown.draw(replace(frame, effort=np.array(efforts)))
            assert {name.rpartition("/")[2] for name in shown._labels} == expected
