"""Buckling of a slender column: Euler's loads and the elastica beyond them.

The elastica in complete elliptic integrals: Timoshenko and Gere, Theory of Elastic Stability, 1961,
section 2.7. With modulus k² = m, load over Euler's load is (2 K / π)². A cantilever under a dead force has
its tip at 2 √m L / K across and (2 E / K − 1) L along; the ends of a column that are pulled towards each
other are (2 E / K − 1) L apart.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk
from support.robots.beam_robots import build, path_of_beams, rectangle, under_force

from tauten.model import Ending, Robot, Simulator, State
from tauten.model.beams import BeamBody, bar
from tauten.model.numerics import Array

L, THIN, E = 1.0, 0.005, 1e9  # the thin side is 1 / 200 of the length
SECTION = bar(2.0 * THIN, THIN)
EI = E * SECTION.bending[0]
DEAD = np.pi**2 * EI / (4.0 * L**2)  # Euler's load of a cantilever under a dead force [N]
TIED = np.pi**2 * EI / L**2  # and under a cable from the tip to the clamp


def column(folder: Path, count: int) -> Robot[BeamBody]:
    """The column along z; it is thin along x. Its cable runs from the clamp to the tip."""
    nodes = np.outer(np.linspace(0.0, L, count + 1), [0.0, 0.0, 1.0])
    beams = path_of_beams(nodes, (1.0, 0.0, 0.0), "column")
    profile = rectangle("column", 2.0 * THIN, THIN)
    return build(folder, nodes, beams, [profile], (E, 0.3, 1000.0), [0], count)


def down(load: float) -> Array:
    """A force along the column (3,) [N], as a multiple of Euler's."""
    return np.array([0.0, 0.0, -load * DEAD])


def lowest_stiffness(robot: Robot[BeamBody], state: State) -> float:
    """Smallest eigenvalue of the exact tangent [N/m]."""
    _, K = robot.forces(state, exact=True)
    tangent = sp.csc_array((K, robot.body.pattern.indices, robot.body.pattern.indptr))
    return float(np.linalg.eigvalsh(tangent.toarray())[0])


def compressed(robot: Robot[BeamBody], load: float) -> State:
    """The straight equilibrium under a load, a multiple of Euler's, stable or not."""
    rest = robot.rest()
    q = rest.q.reshape(-1, 7).copy()
    q[:, 2] *= 1.0 - load * DEAD / (E * SECTION.area)
    state = State(q.ravel(), rest.v)
    force, _ = robot.loaded(np.zeros(3), down(load)).forces(state)
    assert np.abs(force).max() < 1e-9 * DEAD
    return state


@pytest.mark.parametrize("count", [4, 8])
def test_the_tangent_is_singular_at_eulers_load(tmp_path: Path, count: int) -> None:
    """Within 2 % with four elements, and with a quarter of the error with eight."""
    robot = column(tmp_path, count)
    critical = brentq(
        lambda load: lowest_stiffness(robot, compressed(robot, load)), 0.9, 1.1, xtol=1e-5
    )
    assert critical == pytest.approx(1.0, abs=0.02 * (4.0 / count) ** 2)


def test_the_column_stands_below_eulers_load_and_bends_above(tmp_path: Path) -> None:
    robot = column(tmp_path, 16)
    aside = np.array([0.01 * DEAD, 0.0, 0.0])
    for load, bent in ((0.98, False), (1.02, True)):
        simulator, positions = under_force(robot, [down(load) + aside, down(load)], 1e-8, most=800)
        assert (abs(positions[-1][0]) > 0.1 * L) == bent, load
        assert lowest_stiffness(robot, simulator.state) > 0.0, "a stable equilibrium"


@pytest.mark.parametrize("load", [1.02, 1.5, 5.0])
def test_a_straight_column_leaves_the_unstable_branch(tmp_path: Path, load: float) -> None:
    """Pushed exactly along its axis; to the side to which the other half of the elastica would bend, too."""
    robot = column(tmp_path, 32).loaded(np.zeros(3), down(load))
    simulator = Simulator(robot, contact="none")
    simulator.start_from(compressed(robot, load))
    report = simulator.settle(effort=[0.0], tolerance=1e-8)
    assert report.converged
    assert report.ending is Ending.SETTLED
    assert lowest_stiffness(robot, simulator.state) > 0.0
    m = brentq(lambda m: (2.0 * ellipk(m) / np.pi) ** 2 - load, 1e-9, 1.0 - 1e-9)
    across = 2.0 * np.sqrt(m) / ellipk(m) * L
    assert abs(simulator.effector[0, 0]) == pytest.approx(across, abs=1.5e-3)


def test_a_column_that_is_left_no_iterations_is_named_buckled(tmp_path: Path) -> None:
    robot = column(tmp_path, 16).loaded(np.zeros(3), down(1.5))
    simulator = Simulator(robot, contact="none")
    simulator.start_from(compressed(robot, 1.5))
    report = simulator.settle(effort=[0.0], max_iterations=4, load_steps=False)
    assert not report.converged
    assert report.ending is Ending.BUCKLED


def test_a_column_that_comes_to_no_equilibrium_is_not_named_buckled(tmp_path: Path) -> None:
    """Only one that has come to an equilibrium, and has left it, is known to be unstable."""
    robot = column(tmp_path, 16).loaded(np.zeros(3), 0.01 * DEAD * np.eye(3)[0])
    simulator = Simulator(robot, contact="none")
    report = simulator.settle(effort=[0.0], max_iterations=1, load_steps=False)
    assert report.ending is Ending.OUT_OF_ITERATIONS


def test_below_eulers_load_the_straight_column_is_settled(tmp_path: Path) -> None:
    robot = column(tmp_path, 16).loaded(np.zeros(3), down(0.98))
    simulator = Simulator(robot, contact="none")
    report = simulator.settle(effort=[0.0], tolerance=1e-8)
    assert report.ending is Ending.SETTLED
    assert abs(simulator.effector[0, 0]) < 1e-9


def test_a_cable_along_a_straight_column_bends_it(tmp_path: Path) -> None:
    """Held pulled lengths are constraints: the straight column is unstable under them, too."""
    robot = column(tmp_path, 32)
    simulator = Simulator(robot, contact="none")
    assert simulator.settle(position=[0.1 * L], tolerance=1e-8).converged
    m = brentq(lambda m: 2.0 * ellipe(m) / ellipk(m) - 2.0 + 0.1, 1e-9, 0.99)
    assert simulator.effort[0] / TIED == pytest.approx((2.0 * ellipk(m) / np.pi) ** 2, rel=1e-3)


def test_buckled_cantilever_is_the_elastica(tmp_path: Path) -> None:
    """Five times Euler's load."""
    loads = (1.5, 1.1, 1.02, 1.1, 1.5, 2.0, 3.0, 4.0, 5.0)
    robot = column(tmp_path, 32)
    aside = np.array([0.05 * DEAD, 0.0, 0.0])
    forces = [down(1.5) + aside, *[down(load) for load in loads]]
    _, positions = under_force(robot, forces, 1e-8, most=800)
    for load, found in zip(loads, positions[1:], strict=True):
        m = brentq(lambda m, load=load: (2.0 * ellipk(m) / np.pi) ** 2 - load, 1e-9, 1.0 - 1e-9)
        across, along = 2.0 * np.sqrt(m) / ellipk(m) * L, (2.0 * ellipe(m) / ellipk(m) - 1.0) * L
        np.testing.assert_allclose(abs(found[[0, 2]]), abs(np.array([across, along])), atol=1.5e-3)
        assert found[2] * along > 0.0


def test_cable_along_a_column_follows_the_elastica(tmp_path: Path) -> None:
    """The tension rises from Euler's load of a hinged column by the law of the elastica.

    A small force from the side decides to which side it bends, and is taken away again.
    """
    robot = column(tmp_path, 32)
    kick = Simulator(robot.loaded(np.zeros(3), np.array([0.02 * DEAD, 0.0, 0.0])), "none")
    assert kick.settle(position=[0.02 * L]).converged
    simulator = Simulator(robot, "none")
    simulator.start_from(kick.state)
    for position in (0.001, 0.01, 0.05, 0.1, 0.3, 0.5, 0.8):
        assert simulator.settle(position=[position * L], tolerance=1e-8).converged
        m = brentq(
            lambda m, position=position: 2.0 * ellipe(m) / ellipk(m) - 2.0 + position, 1e-9, 0.99
        )
        exact = (2.0 * ellipk(m) / np.pi) ** 2
        assert simulator.effort[0] / TIED == pytest.approx(exact, rel=1e-3)
        assert simulator.position[0] == pytest.approx(position * L, abs=1e-8)
