"""The time steps that a plant takes, and its drives between commands."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.beam_robots import tendon_arm

from tauten.model import Robot, Simulator, load_robot
from tauten.service.plant import DrivenRobot, own_steps
from tauten.service.plant.drives import ALLOWED, MOST
from tauten.service.plant.plant import PlantSettings, warm_plant
from tauten.service.setup import load_setup


@pytest.fixture(scope="module")
def robot(beam_file: Path) -> Robot:
    return load_robot(beam_file)


def test_a_warm_simulator_is_where_it_settles(robot: Robot) -> None:
    warm = warm_plant(robot, PlantSettings())
    np.testing.assert_allclose(warm.driven.simulator.state.q, robot.rest().q, atol=1e-12)
    assert int(warm.fields["steps_per_period"]) == warm.driven.steps


def test_tendons_that_oppose_each_other_are_not_all_wound_at_the_start(tmp_path: Path) -> None:
    """A rod with three tendons was pulled by all of them, which compressed it, and diverged."""
    warm = warm_plant(load_robot(tendon_arm(tmp_path, 10.0)), PlantSettings())
    np.testing.assert_allclose(warm.driven.simulator.tip, [0.0, 0.0, 0.4], atol=1e-9)


@pytest.mark.parametrize("steps", ["single", "converged"])
def test_steps_of_the_controller_are_one_a_period(robot: Robot, steps: str) -> None:
    settings = PlantSettings(steps="single" if steps == "single" else "converged")
    assert warm_plant(robot, settings).own is None


def test_twice_as_many_steps_lead_to_the_same_place(beam_file: Path) -> None:
    """At a slow rate one step a period is not enough, and halving those that are chosen changes little."""
    slow = Simulator(load_robot(beam_file, rate=5.0), "none")
    found = own_steps(slow)
    assert 1 < found.count < MOST
    assert found.error < ALLOWED
    again = own_steps(slow)
    assert (again.count, again.error) == (found.count, found.error)


def test_drives_keep_their_rates(robot: Robot) -> None:
    """A command far away is reached as late as the rate allows, and evenly."""
    driven, step = DrivenRobot(Simulator(robot, "none"), 2), float(robot.h * robot.limits.rate[0])
    far, none = np.zeros(robot.n_a), np.full(robot.n_a, np.nan)
    far[0] = 3.5 * step
    found = []
    for _ in range(5):
        driven.move(far, none)
        found.append(driven.simulator.position[0] / step)
    np.testing.assert_allclose(found, [1.0, 2.0, 3.0, 3.5, 3.5], atol=0.02)


def test_a_robot_that_buckles_on_its_way_ends_at_the_equilibrium() -> None:
    robot = load_setup("trunk").robot
    wound = 1e-3 * np.array([16.912, 9.439, 26.848, 34.259, 8.511, 8.072, 17.232, 15.162])  # m
    simulator, still = Simulator(robot, "none"), Simulator(robot, "none")
    simulator.settle_start()
    driven = DrivenRobot(simulator, steps=1)
    for _ in range(150):
        driven.move(wound, np.full(robot.n_a, np.nan))
    still.settle_start()
    still.settle(position=wound)
    tip, wanted = (robot.effector_values(one.state) for one in (simulator, still))
    np.testing.assert_allclose(tip, wanted, atol=1e-6)
