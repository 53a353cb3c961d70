"""Bases stay valid where contacts are added to a robot file after those that they were made for."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from support.robots.examples import shipped_robot

from tauten.controller import Controller
from tauten.model import load_robot
from tauten.model.load import robot_path
from tauten.reduction import BasisError, ContactBasis
from tauten.reduction.state import StateBasis

WALL = """
[[obstacles]]
name = "wall"
shape = "plane"
parameters = {{ point = [{x}, 0.0, 0.0], normal = [-1.0, 0.0, 0.0] }}

[[contacts]]
against = "wall"
points = 40
"""
AWAY = 5e-3  # m, from the tip to the wall


@pytest.fixture
def walled(tmp_path: Path) -> Path:
    """The shipped finger with a wall that its tip bends towards."""
    source = robot_path("finger")
    robot = shipped_robot("finger")
    shutil.copy(source.with_suffix(".vtu"), tmp_path)
    reach = float(robot.points(robot.rest())[:, 0].max())
    path = tmp_path / "finger.toml"
    path.write_text(source.read_text() + WALL.format(x=reach + AWAY))
    return path


@pytest.mark.long
def test_shipped_bases_serve_a_finger_with_a_wall(walled: Path) -> None:
    robot, basis = load_robot(walled), ContactBasis.load("finger")
    fitted = basis.fitted(robot)
    assert robot.n_c == basis.n_c + 40
    np.testing.assert_array_equal(fitted.Psi[: basis.n_c], basis.Psi)
    assert not fitted.Psi[basis.n_c :].any()
    StateBasis.load("finger").check_robot(robot)


@pytest.mark.long
def test_the_reduced_finger_stops_at_the_wall(walled: Path) -> None:
    controller = Controller.of(walled)
    goal = controller.effector_values + np.array([3.0 * AWAY, 0.0, 0.0])
    for _ in range(100):
        report = controller.step(goal)
    assert report.status.usable
    robot, state = controller.robot, controller.state
    touching = robot.rows(state, contacts=True).contacts
    gaps = touching.found.gaps()[-40:]
    assert -2.0 * robot.tolerance < gaps.min() < robot.tolerance
    assert controller.lam_c[-40:].sum() > 0.01


def test_a_basis_does_not_serve_contacts_that_were_changed(walled: Path) -> None:
    walled.write_text(walled.read_text().replace("points = 99", "points = 98", 1))
    with pytest.raises(BasisError, match="contacts differ"):
        ContactBasis.load("finger").fitted(load_robot(walled))
