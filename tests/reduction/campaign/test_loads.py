"""Equilibria under several loads in the same simulator have the loads that they are given."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.robots.bodies import beam_robot, box_mesh
from support.robots.small_bodies import RUBBER

from benchmarks.contact_basis import sensitivity
from tauten.model import ContactSpace, EmptySpace, Robot, Simulator, State
from tauten.model.numerics import Array
from tauten.reduction.campaign import Design, Run, Snapshots, run_campaign
from tauten.reduction.contact import tip_errors
from tauten.service.bench.reduced import path_accuracy

SIZE = (0.1, 0.02, 0.02)
FORCE = 0.05  # N, on the tip; the second has the opposite sign
END = {"kind": "half_space", "point": [0.0999, 0.0, 0.0], "normal": [1.0, 0.0, 0.0]}


@pytest.fixture(scope="module")
def beam() -> Robot:
    """A beam with one cable, without gravity."""
    return beam_robot(box_mesh(SIZE, (6, 2, 2)), SIZE)


@pytest.fixture(scope="module")
def two_loads(beam: Robot, tmp_path_factory: pytest.TempPathFactory) -> Snapshots:
    """Its equilibria under a force to one side and to the other, of two runs."""
    runs = tuple(
        Run(
            position=np.zeros((1, 1)),
            gravity=np.zeros((3, 1)),
            effector_force=np.array([[0.0], [sign * FORCE], [0.0]]),
        )
        for sign in (1.0, -1.0)
    )
    found = run_campaign(beam, Design("two", runs), tmp_path_factory.mktemp("two"))
    assert found.converged.all()
    return found


def of_tip_errors(robot: Robot, snapshots: Snapshots) -> Array:
    space: ContactSpace = EmptySpace(robot.n_c)
    return tip_errors(robot, snapshots, space).error


def of_sensitivity(robot: Robot, snapshots: Snapshots) -> Array:
    return sensitivity(robot, snapshots)


def test_the_two_loads_bend_it_to_two_sides(beam: Robot, two_loads: Snapshots) -> None:
    sideways = two_loads.effector[1]
    assert sideways[0] - sideways[1] > 1e-3


@pytest.mark.parametrize("apart", [of_tip_errors, of_sensitivity])
def test_a_robot_meets_its_own_equilibria_under_both(
    beam: Robot, two_loads: Snapshots, apart: Callable[[Robot, Snapshots], Array]
) -> None:
    assert apart(beam, two_loads).max() < 1e-5


def test_a_rotation_that_is_a_goal_is_an_error(tmp_path: Path) -> None:
    """Of a beam that is twice as stiff: half of the rotation is missing, which no position shows."""
    turn = {"name": "tip", "kind": "frame", "region": END, "weight": [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]}
    soft, stiff = (
        beam_robot(
            box_mesh(SIZE, (6, 2, 2)), SIZE, effectors=[turn], material={**RUBBER, **modulus}
        )
        for modulus in ({"young_modulus": 1e6}, {"young_modulus": 2e6})
    )
    force = np.array([0.0, FORCE, 0.0])
    run = Run(np.zeros((1, 1)), np.zeros((3, 1)), force[:, None])
    found = run_campaign(soft, Design("one", (run,)), tmp_path)
    simulator, still = Simulator(stiff, contact="none"), np.zeros(soft.n)
    simulator.load(np.zeros(3), force)
    assert simulator.settle(position=[0.0]).converged
    both = simulator.effector_values, soft.effector_values(State(found.q[:, 0], still))
    one, other = (Rotation.from_quat(values[3:], scalar_first=True) for values in both)
    missing = soft.size * (one.inv() * other).magnitude()
    assert of_tip_errors(stiff, found)[0] == pytest.approx(missing, rel=1e-3)
    in_bench = path_accuracy(stiff, EmptySpace(0), found).max_mm
    assert in_bench == pytest.approx(1e3 * missing, rel=1e-3)


def test_so_it_does_in_the_bench(beam: Robot, two_loads: Snapshots) -> None:
    basis = EmptySpace(beam.n_c)
    found = path_accuracy(beam, basis, two_loads)
    assert found.max_mm is not None and found.max_mm < 1e-2


def test_loads_change_by_load_alone(beam: Robot) -> None:
    """And an equilibrium after another load is that of a simulator which never had another."""
    simulator, tips = Simulator(beam, contact="none"), []
    for sign in (1.0, -1.0, 1.0):
        simulator.load(np.zeros(3), np.array([0.0, sign * FORCE, 0.0]))
        assert simulator.settle(position=[0.0]).converged
        tips.append(simulator.effector[0])
    np.testing.assert_allclose(tips[0], tips[2], atol=1e-6)
    assert tips[0][1] - tips[1][1] > 1e-3
    with pytest.raises(AttributeError):
        simulator.robot = beam  # type: ignore[misc]
