"""Rows and curvature of every kind of actuator against finite differences of their potential."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from support.robots.bodies import CABLE, CHAMBER, beam_robot, box_mesh, pneumatic_robot

from tauten.model import Robot, State
from tauten.model.numerics import Array
from tauten.model.points import NodeMotion
from tauten.model.tetra import NodalBody

PUSH = {"name": "push", "point": [0.1, 0.01, 0.01], "direction": [0.0, 3.0, 4.0],
        "max_force": 1.0, "max_travel": 0.1, "max_rate": 1.0}  # fmt: skip
SPREAD = {**PUSH, "name": "spread", "region": {"lower": [0.08, 0.0, 0.0], "upper": [0.1, 0.02, 0.02]},
          "point": None}  # fmt: skip
MOTOR = {"members": ["tendon", "upper"], "gains": [2.0, -1.0], "pretensions": [3.0, 2.0],
         "name": "drum", "max_position": 0.05, "max_effort": 10.0, "max_rate": 1.0}  # fmt: skip
UPPER = {**CABLE, "name": "upper", "points": [[0.01, 0.01, 0.018], [0.1, 0.01, 0.018]],
         "spring": {"stiffness": 500.0, "pretension": 1.0}}  # fmt: skip
KINDS: dict[str, dict[str, object]] = {
    "chamber": {},
    "chamber in quadratic elements": {"mesh": {"file": "balloon.vtu", "element": "quadratic"}},
    "force": {"chambers": [], "forces": [PUSH, SPREAD]},
    "all": {"cables": [CABLE, UPPER], "forces": [PUSH]},
    "coupling": {"cables": [CABLE, UPPER], "couplings": [MOTOR]},
}


def deformed(robot: Robot[NodalBody], seed: int = 0) -> State:
    """A state in which every free node is off its place by about a millimetre, or a fifth of one."""
    rest, size = robot.rest(), 1e-3 if robot.body.mesh.tets.shape[0] < 5000 else 2e-4  # m
    return State(rest.q + size * np.random.default_rng(seed).standard_normal(robot.n), rest.v)


@pytest.mark.parametrize("kind", KINDS)
def test_rows_are_the_derivatives_of_positions(kind: str) -> None:
    robot = pneumatic_robot(**KINDS[kind])
    state, rng, step = deformed(robot), np.random.default_rng(1), 1e-6
    direction = rng.standard_normal(robot.n)

    def positions(by: float) -> Array:
        moved = State(state.q + by * direction, state.v)
        return robot.rows(moved, contacts=False).actuators.delta

    slope = (positions(step) - positions(-step)) / (2.0 * step)
    expected = robot.rows(state, contacts=False).actuators.dense() @ direction
    assert slope.shape == (robot.n_a,)
    np.testing.assert_allclose(slope, expected, rtol=1e-6, atol=1e-12)
    rest = robot.rows(robot.rest(), contacts=False).actuators.delta
    np.testing.assert_allclose(rest, 0.0, atol=1e-17)


@pytest.mark.parametrize("kind", KINDS)
def test_the_tangent_is_the_derivative_of_all_forces(kind: str) -> None:
    robot = pneumatic_robot(**KINDS[kind])
    state, step = deformed(robot), 1e-6
    direction = np.random.default_rng(1).standard_normal(robot.n)
    lam = np.array([0.9, 0.5, 3e3, 0.2])[-robot.n_a :] if kind == "all" else np.full(robot.n_a, 1.5)
    if "chamber" in kind:
        lam[0] = 3e5  # Pa, as stiff as the elements

    def force(by: float) -> Array:
        moved = State(state.q + by * direction, state.v)
        total: Array = robot.forces(moved)[0]
        return total + robot.rows(moved, contacts=False).actuators.H.T @ lam

    _, K = robot.forces(state, lam, exact=True)
    tangent = sp.csc_array((K, robot.body.pattern.indices, robot.body.pattern.indptr))
    change = -(force(step) - force(-step)) / (2.0 * step)
    np.testing.assert_allclose(tangent @ direction, change, atol=1e-6 * np.abs(change).max())
    assert abs(tangent - tangent.T).max() < 1e-9 * abs(tangent).max()


def test_offsets_of_a_coupling_are_part_of_the_potential() -> None:
    robot = pneumatic_robot(**KINDS["coupling"])
    state, step = deformed(robot), 1e-6
    direction = np.random.default_rng(1).standard_normal(robot.n)
    energies = [robot.potential(State(state.q + by * direction, state.v)) for by in (-step, step)]
    slope = (energies[1] - energies[0]) / (2.0 * step)
    assert slope == pytest.approx(-robot.forces(state)[0] @ direction, rel=1e-6)


def test_the_pressure_moves_no_free_body() -> None:
    """The forces of a pressure on all nodes, fixed ones included, have no resultant and no moment."""
    robot = pneumatic_robot(fixed=[{"lower": [0.0, 0.0, 0.0], "upper": [1e-3, 0.02, 0.02]}])
    chambers, x = robot.actuator_set.chambers, robot.body.nodes(deformed(robot))
    every = 3 * np.arange(len(x))
    walls = NodeMotion(x, every, x.size).placed(robot.actuator_set.walls)
    forces = chambers.rows(walls).dense().reshape(-1, 3)
    scale = np.abs(forces).sum()
    assert scale > 0.0
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-12 * scale)
    np.testing.assert_allclose(np.cross(x, forces).sum(axis=0), 0.0, atol=1e-12 * scale)


@pytest.mark.parametrize("kind", ["chamber", "chamber in quadratic elements"])
def test_the_volume_is_that_of_the_removed_elements(kind: str) -> None:
    robot = pneumatic_robot(**KINDS[kind])
    assert robot.actuator_set.chambers.rest_volume == pytest.approx([0.08 * 0.01 * 0.005])


def test_a_force_spread_over_a_region_acts_at_its_centre_of_mass() -> None:
    robot = pneumatic_robot(**KINDS["force"])
    H = robot.rows(robot.rest(), contacts=False).actuators.dense()
    np.testing.assert_allclose(H.reshape(2, -1, 3).sum(axis=1), [[0.0, 0.6, 0.8]] * 2, atol=1e-12)


def test_a_robot_of_cables_alone_has_their_rows() -> None:
    size = (0.1, 0.02, 0.02)
    robot = beam_robot(box_mesh(size, (5, 2, 2)), size)
    motion, actuators = robot.motion(deformed(robot)), robot.actuator_set
    rows = actuators.rows(motion)
    cables = actuators.paths.rows(motion.placed(actuators.stations))
    np.testing.assert_array_equal(rows.dense(), cables.dense())
    assert CHAMBER["name"] not in robot.actuators.names
