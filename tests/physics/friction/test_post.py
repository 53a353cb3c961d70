"""A strip wound round a post: friction holds it, and forces are in equilibrium."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.examples import changed, example

from tauten.model import Robot, load_robot
from tauten.model.numerics import Array

POST = example("09_post")


def drawn(robot: Robot) -> Array:
    """Force of the motor in each step [N]; at the end the post pushes back as much."""
    forces = list[float]()
    for simulator in POST["wind"](robot):
        forces.append(POST["drawn"](simulator))
    held = simulator.contacts.force.sum(axis=0)[0]
    np.testing.assert_allclose(held, forces[-1], rtol=0.01)
    return np.array(forces)


@pytest.mark.long
def test_friction_holds_a_strip_that_is_wound_round_a_post(tmp_path: Path) -> None:
    """Without friction only the strip's stiffness against being straightened holds."""
    held = drawn(load_robot(POST["FILE"]))
    file = changed(tmp_path, "tentacle.toml", ("friction = 0.5", "friction = 0.0"))
    smooth = drawn(load_robot(file))
    assert held.max() > 3.0 * smooth.max()
