"""A strip crawls by friction alone: momentum of what touches a floor."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.examples import changed, example

from tauten.model import Robot, State, load_robot

CRAWLER = example("07_crawler")
STROKE = CRAWLER["STROKE"]


def centre_of_mass(robot: Robot, state: State) -> np.ndarray:
    """Of all nodes: (3,) [m]."""
    mass = robot.body.masses(state).reshape(-1, 3)[:, 0]  # (N,) kg
    return mass @ robot.points(state) / mass.sum()


@pytest.mark.long
@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_the_centre_of_mass_moves_by_friction_alone(friction: float, tmp_path: Path) -> None:
    """Cables act between points of the strip: without friction no force is horizontal."""
    file = changed(tmp_path, "crawler.toml", ("friction = 0.5", f"friction = {friction}"))
    robot = load_robot(file)
    places = []
    for simulator in CRAWLER["crawl"](robot, 1 if friction else 0.4):
        places.append(centre_of_mass(robot, simulator.state))
        contacts = simulator.contacts
        across = contacts.force - contacts.normal_force[:, None] * contacts.contacts.normal
        limit = friction * contacts.normal_force
        assert (np.linalg.norm(across, axis=1) <= limit + 1e-9).all()
    x = np.array(places)[:, 0]
    if friction == 0.0:
        assert np.abs(x - x[0]).max() < 1e-6
    else:
        assert 0.9 * STROKE < x[-1] - x[0] < 1.1 * STROKE
