"""The tripod against SOFA: three servos, position and orientation of its centre, torques."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sofa_robots import port
from support.robots.sofa_robots import MM, robots_folder

from tauten.controller import Controller, ControllerSettings
from tauten.model import Robot, Simulator
from tauten.model.constraints import ConstrainedBody
from tauten.model.numerics import Array

SETTLED = 2e-6  # rows of SOFA that moved more in their last step are no equilibria


@pytest.fixture(scope="module")
def data(reference: Path) -> Path:
    return robots_folder(reference, "tripod_low_model.npz")


@pytest.fixture(scope="module")
def robot(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Robot[ConstrainedBody]:
    made = port(data, tmp_path_factory.mktemp("tripod"), "tripod")
    assert isinstance(made.body, ConstrainedBody)
    return made


def angles(row: Array) -> Array:
    return np.radians([row[f"angle{i}_deg"] for i in (1, 2, 3)])


def test_the_centre_its_orientation_and_torques_are_those_of_sofa(
    data: Path, robot: Robot[ConstrainedBody]
) -> None:
    """19 states, each from the one before: 0.1 µm, 1e-7 of a rotation and 1e-6 of the torques."""
    curve = np.genfromtxt(data / "tripod_low_fpolar.csv", delimiter=",", names=True)
    torques = np.genfromtxt(data / "tripod_low_fpolar_torque.csv", delimiter=",", names=True)
    simulator = Simulator(robot, contact="none")
    compared = 0
    for row, torque in zip(curve, torques, strict=True):
        assert simulator.settle(position=angles(row), tolerance=1e-9).converged
        if row["last_max_dx"] > SETTLED:
            continue
        compared += 1
        values = simulator.robot.effector_values(simulator.state)  # centre, then position and turn
        expected = MM * np.array([row[f"centre_{axis}"] for axis in "xyz"])
        assert np.abs(values[:3] - expected).max() < 1e-7
        turn = Rotation.from_quat(values[[7, 8, 9, 6]]).as_matrix()
        sofa = np.array([row[f"R{i}{j}"] for i in (1, 2, 3) for j in (1, 2, 3)]).reshape(3, 3)
        assert np.abs(turn - sofa).max() < 1e-6
        on_arms = 1e-6 * np.array([torque[f"torque{i}"] for i in ("1_mNmm", "2", "3")])
        assert np.abs(simulator.effort + on_arms).max() < 1e-6
    assert compared == len(curve)


def test_the_work_of_the_servos_is_the_energy_stored(robot: Robot[ConstrainedBody]) -> None:
    simulator = Simulator(robot, contact="none")
    path = np.linspace(0.0, np.radians([-30.0, -50.0, -10.0]), 25)
    energy, power = [], []
    for command in path:
        assert simulator.settle(position=command, tolerance=1e-9).converged
        energy.append(simulator.robot.potential(simulator.state))  # type: ignore[attr-defined]
        power.append(simulator.effort @ (path[1] - path[0]))
    work = np.trapezoid(power)
    assert work == pytest.approx(energy[-1] - energy[0], rel=1e-4)


def test_the_inverse_finds_the_angles_of_a_pose(robot: Robot[ConstrainedBody]) -> None:
    """Position and orientation that three servos can reach lead back to the angles that gave them."""
    goal = np.radians([-25.0, -40.0, -35.0])
    simulator = Simulator(robot, contact="none")
    assert simulator.settle(position=goal, tolerance=1e-9).converged
    target = simulator.robot.effector_values(simulator.state)
    controller = Controller(robot, settings=ControllerSettings(regularisation=1e-6))
    for _ in range(20):
        actuation = controller.step(target)
    assert np.abs(controller.robot.effector_values(controller.state) - target).max() < 2e-6
    assert np.abs(actuation.position - goal).max() < 1e-4
