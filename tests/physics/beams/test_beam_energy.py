"""Energy of a robot made of beams that swings freely, without damping, gravity and cable tension."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.robots.beam_robots import build, path_of_beams, rectangle, under_force
from support.robots.examples import shipped_robot

from tauten.model import Robot, Simulator, State
from tauten.model.beams import BeamBody, assemble_beams, bar
from tauten.model.numerics import Array

LENGTH, SIDES = 0.3, (0.02, 0.01)
SOFT, STIFF = 1e6, 1e9  # Young's modulus [Pa]


def cantilever(folder: Path, young_modulus: float, rate: float) -> Robot[BeamBody]:
    """A beam of ten elements along x."""
    nodes = np.outer(np.linspace(0.0, LENGTH, 11), [1.0, 0.0, 0.0])
    beams = path_of_beams(nodes, (0.0, 0.0, 1.0), "beam")
    return build(
        folder, nodes, beams, [rectangle("beam", *SIDES)], (young_modulus, 0.3, 1100.0), [0], 10,
        controller={"rate": rate},
    )  # fmt: skip


def energy(robot: Robot[BeamBody], state: State) -> float:
    """Elastic and kinetic energy [J]."""
    x, Q = robot.body.pose(state)
    force, K = np.zeros((2 * robot.n_nodes, 3)), np.zeros(len(robot.body.pattern.indices))
    stored = assemble_beams(x, Q, robot.body.beams.arrays, False, robot.body.beam_slot, force, K)
    return stored + 0.5 * float(robot.body.mass @ state.v**2)


def bent(robot: Robot[BeamBody], young_modulus: float, load: float) -> State:
    """At rest under a force P across the tip, load = P L² / E I."""
    P = load * young_modulus * bar(*SIDES).bending[0] / LENGTH**2
    forces = [share * P * np.array([0.0, 0.6, 0.8]) for share in np.linspace(0.125, 1.0, 8)]
    return under_force(robot, forces, 1e-9)[0].state


def released(
    robot: Robot[BeamBody], state: State, duration: float, converged: bool = False
) -> tuple[Array, Array]:
    """Energies (k + 1,) [J] and heights of the tip (k + 1,) [m] of a free motion."""
    simulator = Simulator(robot, contact="none")
    simulator.start_from(state)
    energies, heights = [energy(robot, state)], [simulator.effector[0, 2]]
    for _ in range(round(duration * robot.integration.rate)):
        simulator.step(effort=np.zeros(robot.n_a), converged=converged)
        energies.append(energy(robot, simulator.state))
        heights.append(simulator.effector[0, 2])
    return np.array(energies), np.array(heights)


@pytest.mark.parametrize(
    ("rate", "load"),
    [
        (50.0, 0.2),
        (50.0, 8.0),
        (200.0, 8.0),
        pytest.param(1000.0, 0.2, marks=pytest.mark.slow),
        pytest.param(1000.0, 8.0, marks=pytest.mark.slow),
    ],
)
def test_energy_of_a_free_swing_falls_in_every_step(
    tmp_path: Path, rate: float, load: float
) -> None:
    """From a small deflection, and from one of 90° at the tip."""
    robot = cantilever(tmp_path, SOFT, rate)
    energies, heights = released(robot, bent(robot, SOFT, load), 1.5)
    assert np.diff(energies).max() < 0.0
    assert heights.min() < -0.3 * heights[0], "it swings to the other side"


def test_energy_lost_falls_with_the_time_step(tmp_path: Path) -> None:
    """Implicit Euler loses energy at first order: a quarter of the step, a quarter of the loss."""
    lost = []
    for rate in (100.0, 400.0):
        robot = cantilever(tmp_path, SOFT, rate)
        energies, _ = released(robot, bent(robot, SOFT, 0.2), 0.5)
        lost.append(1.0 - energies[-1] / energies[0])
    assert lost[0] / lost[1] == pytest.approx(4.0, rel=0.35)


def test_random_velocities_calm_down(tmp_path: Path) -> None:
    """Vibrations that a step does not resolve lose their energy, whatever they are."""
    robot = cantilever(tmp_path, SOFT, 50.0)
    rng = np.random.default_rng(1)
    v = np.zeros((10, 6))
    v[:, :3] = rng.standard_normal((10, 3))
    energies, _ = released(robot, replace(robot.rest(), v=v.ravel()), 2.0)
    assert np.diff(energies).max() < 0.0
    assert energies[-1] < 0.01 * energies[0]


def test_energy_of_the_shipped_manipulator_falls_when_a_cable_is_cut() -> None:
    """At its own control rate, without its damping, weight and contacts."""
    shipped = shipped_robot("manipulator")
    assert isinstance(shipped.body, BeamBody)
    plain = replace(shipped.integration, rayleigh_mass=0.0, rayleigh_stiffness=0.0)
    robot = shipped.loaded(np.zeros(3), np.zeros(3 * len(shipped.effector_names))).with_integration(
        plain
    )
    simulator = Simulator(robot, contact="none")
    assert simulator.settle(effort=10.0 * np.eye(robot.n_a)[0]).converged
    energies, _ = released(robot, simulator.state, 0.5)
    assert np.diff(energies).max() < 0.0


@pytest.mark.parametrize("converged", [False, True])
def test_energy_of_a_stiff_beam_falls_when_it_is_released(tmp_path: Path, converged: bool) -> None:
    """The first period is three steps long; on straight lines one linearisation would gain energy."""
    robot = cantilever(tmp_path, STIFF, 50.0)
    start = bent(robot, STIFF, 1.0)
    energies, _ = released(robot, start, 0.2, converged)
    assert np.diff(energies).max() < 0.0
    if not converged:
        straight, _ = released(replace(robot, body=replace(robot.body, tree=None)), start, 0.2)
        assert np.diff(straight).max() > energy(robot, start)


@pytest.mark.slow
def test_rolling_over_a_potential_hill_gains_no_energy(tmp_path: Path) -> None:
    """A beam that is compressed straight has an indefinite tangent; a push lets it snap aside."""
    robot = cantilever(tmp_path, SOFT, 200.0)
    buckling = 0.25 * np.pi**2 * SOFT * bar(*SIDES).bending[0] / LENGTH**2
    loaded = robot.loaded(np.zeros(3), np.array([-4.0 * buckling, 0.0, 0.0]))
    simulator = Simulator(loaded, contact="none")
    push = np.zeros((10, 6))
    push[:, 2] = 1e-3 * np.linspace(0.1, 1.0, 10)
    simulator.start_from(replace(loaded.rest(), v=push.ravel()))
    total = []
    for _ in range(400):
        assert simulator.step(effort=[0.0], converged=True).converged
        state = simulator.state
        total.append(loaded.potential(state) + loaded.body.kinetic_energy(state))
    assert np.diff(total).max() <= 1e-12 * np.ptp(total)
    assert np.linalg.norm(simulator.effector[0, 1:]) > 0.3 * LENGTH, "it has snapped aside"
