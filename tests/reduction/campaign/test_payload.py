"""The payload of training loads: a share of the weight, and less where that would fold the robot."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.thumb import thumb_mesh, thumb_settings

from tauten.model import Robot, Simulator
from tauten.model.load import build_robot
from tauten.model.schema import RobotConfig
from tauten.reduction.campaign import payload


def thumb_of(young_modulus: float) -> Robot:
    """The thumb without gravity, of a softer or stiffer material."""
    settings = thumb_settings()
    settings["material"]["young_modulus"] = young_modulus
    settings["gravity"] = [0.0, 0.0, 0.0]
    return build_robot(RobotConfig.model_validate(settings), thumb_mesh(), "test")


def test_a_robot_that_bears_it_carries_a_fifth_of_its_weight() -> None:
    robot = thumb_of(0.6e6)
    assert payload(robot, 1) == pytest.approx(0.2 * 9.81 * robot.body.moving_mass)


def test_a_softer_robot_carries_what_moves_it_by_half_its_size_to_first_order() -> None:
    """Compared with equilibria of the full model under a thousandth of it."""
    robot = thumb_of(0.6e3)
    force = payload(robot, 1)
    assert force < 0.1 * 9.81 * robot.body.moving_mass
    simulator, moved = Simulator(robot, contact="none"), []
    start = robot.effector(robot.rest())[0]
    for axis in np.eye(3):
        simulator.load(np.zeros(3), 1e-3 * force * axis)
        simulator.reset()
        assert simulator.settle(effort=[0.0], tolerance=1e-10).converged
        moved.append(simulator.effector[0] - start)
    assert np.linalg.norm(moved, 2) == pytest.approx(0.5e-3 * robot.size, rel=0.01)
