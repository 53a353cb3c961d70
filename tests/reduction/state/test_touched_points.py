"""Reduced robots that yield as the full one at points that something touches."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.state_bases import basis_of

from tauten.model import Robot, load_robot, row_compliance
from tauten.model.numerics import Array
from tauten.reduction.campaign import TouchedRobot, touched_robot
from tauten.reduction.state import enriched, reduced_robot, reducible
from tauten.reduction.state.modes import touched_responses, with_own

CLAW = Path("examples/claw.toml")
POINTS = 6
LIFTED = (0.0, 0.0, 0.012)  # m, position of the claw in the file of the lift


@pytest.fixture(scope="module")
def claw() -> TouchedRobot:
    """The gripper of the lift, with few points on the inside of its fingers."""
    found = touched_robot(CLAW, ["inside"], POINTS)
    assert found is not None
    return found


def yields(robot: Robot) -> Array:
    """Compliance of the points in three directions (3 k, 3 k) [m/N] at rest, with the drive held."""
    system = robot.linearise(robot.rest(), None, replace(robot.integration, static=True))
    rows = robot.rows(robot.rest(), contacts=False)
    drive = rows.actuators.dense()[-1:]
    H = np.vstack([rows.effectors.dense(), drive])
    W = row_compliance(system, H, np.zeros(len(H))).W
    return W[:-1, :-1] - np.outer(W[:-1, -1], W[-1, :-1]) / W[-1, -1]


def test_it_yields_as_the_full_robot_at_the_points(claw: TouchedRobot) -> None:
    robot = claw.robot
    body = reducible(robot)
    responses = touched_responses(robot.fork(), body, POINTS)
    assert responses.shape == (len(body.weight), 3 * POINTS)
    modes = enriched(np.zeros((len(body.weight), 0)), responses, body.weight)
    every = np.arange(body.n_elements)
    states = basis_of(robot, with_own(body, modes), every, np.ones(len(every)))
    reduced = reduced_robot(robot, states)
    assert reduced.n == 3 * POINTS + 1
    full, found = yields(robot.fork()), yields(reduced)
    np.testing.assert_allclose(found, full, atol=1e-6 * np.abs(full).max())


def test_points_are_where_as_many_candidates_of_a_contact_are(
    claw: TouchedRobot, tmp_path: Path
) -> None:
    for name in ("claw.toml", "lift.toml", "parcel.toml", "fork.vtu", "cube.vtu"):
        (tmp_path / name).write_bytes((CLAW.parent / name).read_bytes())
    file = tmp_path / "lift.toml"
    text = file.read_text(encoding="utf-8")
    file.write_text(text.replace('"vertices"', str(POINTS), 1), encoding="utf-8")
    robot = load_robot(file)
    pair = robot.contacts.pairs[0]

    x = robot.motion(robot.rest()).placed(robot.vertices).y
    assert len(pair.nodes) == POINTS
    at = np.einsum("mi,mij->mj", pair.weights, x[pair.nodes])
    np.testing.assert_allclose(at - claw.places, np.tile(LIFTED, (POINTS, 1)), atol=1e-12)
