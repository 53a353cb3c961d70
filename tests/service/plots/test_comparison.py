"""Figures of `tauten compare` have the shape of the robot."""

from __future__ import annotations

import pytest

from tauten.model import Simulator
from tauten.service.plots.body import Side
from tauten.service.plots.comparison import draw_states


@pytest.mark.parametrize("name", ["diamond", "trunk"])
def test_the_axes_take_most_of_the_figure_of_a_flat_robot_and_of_a_tall_one(name: str) -> None:
    robot = Simulator.of(name).robot
    rest = robot.rest()
    figure, panels = draw_states(robot, {"at rest": rest, "again": rest}, Side())
    figure.draw_without_rendering()
    assert all(axes.get_position().height > 0.5 for axes in panels)
