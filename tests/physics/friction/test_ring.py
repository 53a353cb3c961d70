"""A ring rolls by friction alone: it does not slide, and without friction it stays in place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.examples import changed, example

from tauten.controller import controller_setup, warm_controller
from tauten.model import load_robot
from tauten.model.schema import read_toml

RING = example("13_ring")


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_ring_rolls_by_friction_alone(friction: float, tmp_path: Path) -> None:
    """Cables act between points of the ring: without friction no force on it is horizontal."""
    change = ("friction = 0.5", f"friction = {friction}")
    robot = load_robot(changed(tmp_path, "ring.toml", change))
    places = []
    for simulator in RING["roll"](robot, 0.25 if friction else 0.1):
        places.append(simulator.tip[0])
        force = simulator.contacts.force  # (m, 3) N
        limit = friction * force[:, 2]
        assert (np.linalg.norm(force[:, :2], axis=1) <= limit + 1e-9).all()
    moved = np.array(places) - places[0]
    if friction == 0.0:
        assert np.abs(moved).max() < 1e-6
    else:
        assert moved[-1] > 0.3 * RING["RADIUS"]
        np.testing.assert_allclose(moved[-1], RING["RADIUS"] * RING["turned"](simulator), rtol=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("way", [0.01, -0.01])
def test_its_middle_follows_a_slow_target(way: float) -> None:
    """At 200 Hz, at 10 mm/s, by decisions that look ahead one tick; see docs/grasping.md for others."""
    rate, seconds = 200.0, 1.0
    contents = read_toml(RING["FILE"])
    contents["controller"]["horizon"] = 0.0
    controller = warm_controller(controller_setup(contents, RING["FILE"], rate=rate))
    start, away = controller.effector_values, []
    for tick in range(int(1.2 * seconds * rate)):
        goal = start.copy()
        goal[0] += way * min((tick + 1) / (seconds * rate), 1.0)
        assert controller.step(goal).status.usable
        away.append(abs(controller.effector_values[0] - goal[0]))
    assert max(away) < 2e-4 and away[-1] < 1e-4  # m
