"""The time steps that a plant takes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tauten.model import Robot, load_robot
from tauten.service.plant.plant import PlantSettings, chosen_steps, warm_simulator


@pytest.fixture(scope="module")
def robot(beam_file: Path) -> Robot:
    return load_robot(beam_file)


def test_a_warm_simulator_is_where_it_settles(robot: Robot) -> None:
    simulator, duration = warm_simulator(robot, converged=True)
    np.testing.assert_allclose(simulator.state.q, robot.rest().q, atol=1e-12)  # has no weight
    assert duration > 0.0


@pytest.mark.parametrize("steps", ["single", "converged"])
def test_steps_that_are_asked_for_are_taken(robot: Robot, steps: str) -> None:
    settings = PlantSettings(steps="single" if steps == "single" else "converged")
    assert chosen_steps(robot, settings)[1] == settings


@pytest.mark.parametrize(("rate", "steps"), [(0.1, "converged"), (10_000.0, "single")])
def test_auto_depends_on_the_time_that_a_period_has(
    beam_file: Path, rate: float, steps: str
) -> None:
    found = chosen_steps(load_robot(beam_file, rate=rate), PlantSettings(steps="auto"))[1]
    assert found == replace(PlantSettings(), steps=steps)
