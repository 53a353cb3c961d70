"""A closed loop whose streams start apart, and that is held on its way, comes to rest at its target."""

from __future__ import annotations

import numpy as np
import pytest
from support.processes import ROBOT, write_robot

from tauten.controller import Controller
from tauten.controller.qpcc import Status
from tauten.model import Robot, Simulator, load_robot
from tauten.model.numerics import Array
from tauten.service.node import LARGEST, Feedback
from tauten.service.plant import DrivenRobot

EFFECTORS = """\
[[effectors]]
name = "tool"
kind = "frame"
region = { lower = [0.099, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }

[[effectors]]
name = "span"
kind = "distance"
point = [0.1, 0.01, 0.018]
other = [0.05, 0.01, 0.018]
"""
GAIN, TICKS = 2.0, 220
LATER, HELD = 10, range(20, 60)  # ticks


@pytest.fixture(scope="module")
def robots(tmp_path_factory: pytest.TempPathFactory) -> tuple[Robot, Robot]:
    """The controller's beam, and one that is a tenth stiffer."""
    text = ROBOT.split("[[effectors]]", maxsplit=1)[0] + EFFECTORS
    file = write_robot(tmp_path_factory.mktemp("beam"), text)
    return load_robot(file), load_robot(file, young_scale=1.1)


def at_rest(robots: tuple[Robot, Robot], goal: Array) -> Array:
    """Values (n_v,) of the stiffer robot, whose winches pull forces, at the end.

    Args:
        robots: the controller's and the stiffer one.
        goal: (n_v,) targets; those of the second effector start later.
    """
    controller, driven = Controller(robots[0]), DrivenRobot(Simulator(robots[1], "none"), 1)
    layout, none = robots[0].effector_layout, np.full(robots[0].n_a, np.nan)
    feedback, second = Feedback(layout, GAIN, LARGEST * robots[0].size), layout.values_of(1)
    for tick in range(TICKS):
        controller.prepare()
        model, values = controller.effector_values, goal.copy()
        feedback.update(model, driven.simulator.effector_values, robots[0].h)
        if tick < LATER:
            values[second] = model[second]
        if tick in HELD:
            left = controller.hold()
        else:
            left = controller.decide(layout.moved(values, feedback.correction))
            assert left.status is Status.OK
        controller.advance()
        driven.move(none, left.effort)
    return driven.simulator.effector_values


@pytest.mark.long
def test_a_hold_on_the_way_and_streams_that_start_apart_do_not_change_where_it_rests(
    robots: tuple[Robot, Robot],
) -> None:
    layout, simulator = robots[0].effector_layout, Simulator(robots[0], "none")
    assert simulator.settle(position=[0.0, 0.004]).converged
    goal = simulator.effector_values
    assert layout.error(at_rest(robots, goal), goal) < 1e-4  # 3 mm apart without feedback
