"""Time steps iterated to convergence: balance of momentum, energy, order, rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.robots.bodies import beam_robot, box_mesh
from support.robots.examples import shipped_robot

from tauten.model import Robot, Simulator
from tauten.model.beams import BeamBody
from tauten.model.body import SparseBody
from tauten.model.numerics import Array
from tauten.model.simulation.converged_step import without_gain
from tauten.model.state import State
from tauten.model.step import no_forces
from tauten.model.tetra import NodalBody

SIZE, CELLS = (0.1, 0.02, 0.02), (6, 2, 2)


def undamped(robot: Robot) -> Robot[SparseBody]:
    """The robot without its damping."""
    assert isinstance(robot.body, SparseBody)
    plain = replace(robot.integration, rayleigh_mass=0.0, rayleigh_stiffness=0.0)
    return robot.with_integration(plain)


def bar_robot() -> Robot[NodalBody]:
    return beam_robot(box_mesh(SIZE, CELLS), SIZE)


def energy(robot: Robot[NodalBody] | Robot[BeamBody], state: State) -> float:
    """Potential and kinetic energy [J]."""
    return robot.potential(state) + robot.body.kinetic_energy(state)


def swing(robot: Robot[NodalBody] | Robot[BeamBody], start: State, steps: int) -> Array:
    """Energy (steps + 1,) [J] of a free motion, cables slack."""
    simulator = Simulator(robot, contact="none")
    simulator.start_from(start)
    energies = [energy(robot, start)]
    for _ in range(steps):
        assert simulator.step(effort=np.zeros(robot.n_a), converged=True).converged
        energies.append(energy(robot, simulator.state))
    return np.array(energies)


def test_end_of_a_step_balances_the_forces_there() -> None:
    """M (v − v₀) / h = f(q) − C v: the defining equation, with the forces of the model itself."""
    damped = replace(bar_robot().integration, rayleigh_mass=3.0)
    robot = bar_robot().with_integration(damped).loaded(np.array([0.0, 0.0, -9.81]), np.zeros(3))
    simulator = Simulator(robot, contact="none")
    v = np.random.default_rng(0).standard_normal(robot.n)
    simulator.start_from(State(robot.rest().q, v))
    simulator.step(effort=[0.0], converged=True)
    state, a = simulator.state, 3.0
    balance = (
        robot.body.tetrahedra.mass * (state.v - v) / robot.h
        + a * robot.body.tetrahedra.mass * state.v
    )
    force = robot.forces(state)[0]
    assert np.abs(balance - force).max() < 1e-4 * np.abs(force).max()
    assert np.abs((state.q - robot.rest().q) / robot.h - state.v).max() < 1e-9


def test_a_step_gains_no_more_than_the_work_of_winches_and_obstacles() -> None:
    """What it would gain besides is taken from its velocity, as far as that has it."""
    robot = undamped(bar_robot())
    before, rng = robot.rest(), np.random.default_rng(2)
    v = rng.standard_normal(robot.n)
    after = robot.advance(before, v, 1e-5)
    tension = replace(no_forces(robot.n_a, 0), effort=np.full(robot.n_a, 3.0))
    pulled = robot.rows(after).actuators.delta - robot.rows(before).actuators.delta
    kinetic, work = robot.body.kinetic_energy(after), float(3.0 * pulled.sum())
    assert work != 0.0
    for pushed in (0.25 * kinetic, 0.5 * kinetic):
        end = without_gain(robot, before, after, tension, pushed)
        gained = robot.energy(end) - robot.energy(before)
        assert gained == pytest.approx(pushed + work, abs=1e-9 * kinetic)
    still = without_gain(robot, before, after, tension, -2.0 * kinetic)
    assert not still.v.any()
    free = without_gain(robot, before, after, tension, 2.0 * kinetic)
    np.testing.assert_array_equal(free.v, after.v)


def test_momentum_of_rotating_nodes_is_the_derivative_of_their_kinetic_energy() -> None:
    """By central differences over turns of the end about the fixed axes."""
    robot = shipped_robot("manipulator")
    assert isinstance(robot.body, BeamBody)
    generator = np.random.default_rng(1)
    v0, v = generator.standard_normal((2, robot.n)) * 20.0
    start = State(robot.rest().q, v0)

    def moved(state: State, dq: Array) -> State:
        return robot.advance(state, dq / robot.h, robot.h)

    end = moved(start, robot.h * v)
    np.testing.assert_allclose(robot.body.velocity(start, end), v, rtol=1e-9, atol=1e-9)
    force = robot.body.at_end(start, end, robot.body.mass * (v - v0) / robot.h)
    for _ in range(5):
        d = generator.standard_normal(robot.n)
        ends = [robot.body.velocity(start, moved(end, sign * 1e-5 * d)) for sign in (1.0, -1.0)]
        energies = [robot.body.kinetic_energy(replace(start, v=v - v0)) for v in ends]
        slope = (energies[0] - energies[1]) / 2e-5
        assert slope == pytest.approx(force @ d, rel=1e-6)


@pytest.mark.parametrize(
    "make", [bar_robot, pytest.param(lambda: shipped_robot("manipulator"), marks=pytest.mark.slow)]
)
def test_energy_of_a_free_swing_falls_in_every_step(make: Callable[[], Robot]) -> None:
    """From wild velocities, which one linearisation a step turns into energy."""
    robot = undamped(make())
    assert isinstance(robot.body, NodalBody | BeamBody)
    robot = robot.loaded(np.zeros(3), np.zeros(3 * len(robot.effector_names)))
    v = np.zeros((robot.n // 3, 3))
    v[:: 2 if isinstance(robot.body, BeamBody) else 1] = 5.0 * np.random.default_rng(
        2
    ).standard_normal(3)
    energies = swing(robot, State(robot.rest().q, v.ravel()), 60)
    assert np.diff(energies).max() < 1e-13 * energies[0], "beyond rounding"
    assert np.diff(energies[:15]).max() < 0.0


@pytest.mark.slow
def test_a_hanging_robot_with_held_cables_comes_to_rest(finger: Robot) -> None:
    """Where its weight, the cable and contacts are in equilibrium."""
    robot = undamped(finger)
    simulator, still = Simulator(robot), Simulator(robot)
    position = 0.5 * robot.limits.position_max
    assert still.settle(position=position).converged
    simulator.settle(position=0.8 * position)
    energies = []
    for _ in range(250):
        assert simulator.step(position=position, converged=True).converged
        energies.append(energy(robot, simulator.state))
    assert np.diff(energies[1:]).max() < 1e-9 * energies[0]
    assert np.abs(simulator.effector - still.effector).max() < 1e-5
    assert np.abs(simulator.state.v).max() < 1e-4


def test_the_first_iteration_is_the_step_with_one_linearisation() -> None:
    """Both steps become the same as the time step becomes short, at second order."""
    apart = []
    for rate in (400.0, 1600.0):
        robot = beam_robot(box_mesh(SIZE, CELLS), SIZE, controller={"rate": rate})
        ends = []
        for converged in (False, True):
            simulator = Simulator(robot, contact="none")
            v = np.zeros((robot.n // 3, 3))
            v[:, 2] = 0.5
            simulator.start_from(State(robot.rest().q, v.ravel()))
            simulator.step(effort=[0.0], converged=converged)
            ends.append(simulator.effector)
        apart.append(float(np.abs(ends[0] - ends[1]).max()))
    assert apart[0] > 8.0 * apart[1]


def test_converged_quasi_static_steps_are_equilibria() -> None:
    robot = beam_robot(box_mesh(SIZE, CELLS), SIZE, integration={"scheme": "quasi-static"})
    simulator, still = Simulator(robot, contact="none"), Simulator(robot, contact="none")
    assert simulator.step(position=[0.01], converged=True).converged
    still.settle(position=[0.01])
    np.testing.assert_allclose(simulator.effector, still.effector, atol=1e-9)
