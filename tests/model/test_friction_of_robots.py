"""Friction of robot files: what is refused, which bases stay valid, and steps of reduced robots."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tauten.controller.loading import controller_setup
from tauten.model import EmptySpace, RobotFileError, Simulator, load_robot
from tauten.model.load import robot_path
from tauten.model.schema import read_toml

FINGER = robot_path("finger")


def finger(**friction: float) -> dict[str, Any]:
    """The shipped finger, some pairs of whose notches rub: coefficients by the name of their candidates."""
    contents: dict[str, Any] = read_toml(FINGER)
    for contact in contents["contacts"]:
        if contact["candidates"] in friction:
            contact["friction"] = friction[contact["candidates"]]
    return contents


@pytest.mark.parametrize("wrong", [-0.1, float("nan"), float("inf"), 1e300, 100.1])
def test_a_coefficient_is_a_number_from_0_to_100(wrong: float) -> None:
    with pytest.raises(RobotFileError, match=r"contacts\.2\.friction: Input should be .*, found"):
        controller_setup(finger(notch3_below=wrong), FINGER)


@pytest.mark.long
def test_pairs_that_rub_have_unit_columns_and_the_others_the_basis_which_stays_valid() -> None:
    """The shipped bases of states and of forces were made without friction."""
    setup = controller_setup(finger(notch2_below=0.4, notch3_below=0.4), FINGER, model="reduced")
    assert setup.robot.digest == load_robot("finger").digest
    simulator = Simulator(setup.robot, setup.contact)
    for pulled in np.linspace(0.0, 0.022, 8):
        assert simulator.move(position=[pulled]).converged
    contacts, forces = simulator.contacts, simulator.forces
    normal, friction = contacts.normal_force, contacts.contacts.friction
    across = contacts.force - normal[:, None] * contacts.contacts.normal
    assert (np.linalg.norm(across, axis=1) <= friction * normal + 1e-9).all()
    rubbing = normal[friction > 0.0].max()
    assert rubbing > 1e-3 and normal[friction == 0.0].max() > 1e-3
    none, slots = EmptySpace(setup.robot.n_c), contacts.contacts.slots
    units = forces.at_candidates(none, setup.robot.contacts.without_friction)[slots]
    np.testing.assert_allclose(units[friction > 0.0], normal[friction > 0.0], atol=1e-12)
    # columns of the basis that reach candidates with friction give these no force
    np.testing.assert_allclose(simulator.lam_c[slots], normal, atol=1e-12)
