"""Which contacts are of bodies that nothing but contact joins."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.robots.blocks import box, free_bodies, moving, speeds, touching

from tauten.model import Robot
from tauten.model.contact.detection import NEAREST
from tauten.model.contact.sides import hits_of

EDGE = 0.02  # m
FACE = {"lower": [EDGE - 1e-6, -1.0, -1.0], "upper": [EDGE + 1e-6, 1.0, 1.0], "body": "body_other"}


def two_cubes(gap: float, rigid: bool, cells: int = 2, **changes: Any) -> Robot:
    """Two cubes, one behind the other along x, of which the first one may touch the other."""
    cube, places = (EDGE, EDGE, EDGE), {"one": 0.0, "other": EDGE + gap}
    bodies = {name: box(cube, (x, 0.0, 0.0), cells) for name, x in places.items()}
    return free_bodies(bodies, [touching("one", "other")], 50.0, rigid, **changes)


@pytest.mark.parametrize("rigid", [True, False])
def test_a_body_may_move_far_from_another_one_that_only_contact_joins(rigid: bool) -> None:
    (pair,) = two_cubes(0.001, rigid).contacts.pairs
    ((candidates, triangles),) = pair.loose
    assert len(candidates) == len(pair.nodes)
    assert len(triangles) == len(pair.triangles)


def test_bodies_that_glue_joins_do_not_move_far_from_each_other_though_they_are_free() -> None:
    glue = {"kind": "glue", "region": FACE, "to": {"kind": "all", "body": "body_one"}}
    (pair,) = two_cubes(0.0, rigid=False, attachments=[glue]).contacts.pairs
    assert pair.loose == ()


@pytest.mark.parametrize(("speed", "met"), [(0.049, False), (0.051, True), (1.0, True)])
def test_a_triangle_is_met_by_what_reaches_it_within_the_step(speed: float, met: bool) -> None:
    """A gap of 1 mm is passed within 20 ms from 5 cm/s on; the last 5 % of a way are grazing."""
    robot = two_cubes(0.001, rigid=True)
    state = moving(robot, speeds(2, np.array([speed / 0.95, 0.0, 0.0]))).state
    x, end = (
        robot.motion(at).placed(robot.vertices).y
        for at in (state, robot.advance(state, state.v, robot.h))
    )
    (pair,) = robot.contacts.pairs
    hits = hits_of(x, end, (pair.nodes, pair.weights, pair.triangles), pair.loose)
    assert (hits is not None) is met


def test_of_bodies_beyond_the_alarm_distance_the_nearest_candidates_are_found() -> None:
    """Two cubes, 8 mm from each other: what reaches 9 mm finds the face, and nothing that reaches less."""
    robot = two_cubes(0.008, rigid=True)
    x = robot.motion(robot.rest()).placed(robot.vertices).y
    contacts = robot.contacts
    assert contacts.alarm_distance < 0.008
    assert len(contacts.detect(x).slots) == len(contacts.reaching(0.0079).detect(x).slots) == 0
    found = contacts.reaching(0.009).detect(x)
    assert 0 < len(found.slots) <= NEAREST
    np.testing.assert_allclose(found.gap, 0.008, rtol=1e-9)
    np.testing.assert_allclose(found.normal, np.tile([-1.0, 0.0, 0.0], (len(found.slots), 1)))


def test_within_the_alarm_distance_a_longer_reach_changes_nothing() -> None:
    robot = two_cubes(0.001, rigid=True)
    x = robot.motion(robot.rest()).placed(robot.vertices).y
    near, far = robot.contacts.detect(x), robot.contacts.reaching(0.009).detect(x)
    for field in ("slots", "gap", "normal", "vertices", "coefficients"):
        np.testing.assert_array_equal(getattr(near, field), getattr(far, field))


@pytest.mark.parametrize("thickness", [0.0, 2e-3])
@pytest.mark.parametrize(("gap", "within"), [(4.9e-3, True), (5.1e-3, False)])
def test_the_alarm_distance_is_that_of_the_surfaces_of_loose_bodies(
    gap: float, within: bool, thickness: float
) -> None:
    """Whatever the distance from which they push each other: beyond it not all of a face is found."""
    contact = {"alarm_distance": 5e-3, "distance": thickness}
    robot = two_cubes(gap, rigid=True, cells=8, contact=contact)
    x = robot.motion(robot.rest()).placed(robot.vertices).y
    found = robot.contacts.reaching(0.006).detect(x)
    np.testing.assert_allclose(found.gap, gap - thickness, rtol=1e-9)
    assert (len(found.slots) == 9 * 9) is within
    assert len(found.slots) > 0 and (within or len(found.slots) <= NEAREST)
