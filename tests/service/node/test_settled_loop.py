"""A closed loop whose robot sags before it starts, in logical time."""

from __future__ import annotations

import numpy as np
import pytest

from tauten.controller import warm_controller
from tauten.service.bench import follow
from tauten.service.node import LARGEST
from tauten.service.node.plausibility import MeasurementCheck
from tauten.service.plant import PlantSettings, warm_plant
from tauten.service.setup import load_setup

SAG = 5e-3  # m, of the pneumatic finger's tip


@pytest.mark.slow
def test_a_robot_that_sags_is_no_frozen_measurement() -> None:
    setup = load_setup("pneumatic_finger")
    controller = warm_controller(setup)
    driven = warm_plant(setup.robot, PlantSettings()).driven
    plant = driven.simulator
    robot, start = setup.robot, controller.effector_values
    layout = robot.effector_layout
    rest = robot.effector_values(robot.rest())
    assert layout.lengths(layout.difference(start, rest)).max() > SAG
    np.testing.assert_allclose(plant.effector_values, start, atol=1e-5)
    check = MeasurementCheck(layout, robot.size, LARGEST * robot.size)
    assert check.reason(start, plant.effector_values, robot.h) == ""
    stay = np.tile(start, (100, 1))
    trace = follow(controller, driven, stay, closed=True, drive="tension")
    assert trace.error.max() < 1e-5
    assert check.reason(controller.effector_values, plant.effector_values, robot.h) == ""
