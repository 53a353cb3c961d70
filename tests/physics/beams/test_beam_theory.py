"""Cantilevers against beam theory, statics and dynamics, under refinement."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.bodies import beam_robot, box_mesh

from tauten.model import Simulator, State

LENGTH, SIDE = 0.2, 0.02
E, RHO, G = 1e6, 1000.0, 9.81
SIZE = (LENGTH, SIDE, SIDE)


def sag(cells: int, gravity: float) -> float:
    """Tip deflection under its own weight [m] of a mesh with this many cells over the height."""
    mesh = box_mesh(SIZE, (10 * cells, cells, cells))
    material = {"young_modulus": E, "poisson_ratio": 0.0, "density": RHO}
    robot = beam_robot(mesh, SIZE, gravity=[0.0, 0.0, -gravity], material=material)
    simulator = Simulator(robot, contact="none")
    rest = simulator.effector[0, 2]
    assert simulator.settle(effort=[0.0], tolerance=1e-10).converged
    return float(rest - simulator.effector[0, 2])


def test_sag_converges_to_timoshenko_at_second_order() -> None:
    gravity = 0.01 * G  # small enough for linear theory
    w, second_moment = RHO * gravity * SIDE**2, SIDE**4 / 12
    bending = w * LENGTH**4 / (8 * E * second_moment)
    shear = w * LENGTH**2 / (2 * (5 / 6) * (E / 2) * SIDE**2)
    errors = [1.0 - sag(cells, gravity) / (bending + shear) for cells in (1, 2, 4)]
    assert all(error > 0.0 for error in errors)  # displacement elements are too stiff
    # locking elements approach from far below: the last halving must cut the error at order > 1.3
    assert np.log2(errors[1] / errors[2]) > 1.3
    assert errors[2] < 0.2


def test_free_fall_of_an_unloaded_step() -> None:
    """Implicit Euler is exact for constant acceleration in velocity: v = g t."""
    mesh = box_mesh(SIZE, (4, 1, 1))
    robot = beam_robot(mesh, SIZE, gravity=[0.0, 0.0, -G], fixed=[
        {"lower": [0.0, 0.0, 0.0], "upper": [0.0, SIDE, SIDE]}], material={
        "young_modulus": 100.0, "poisson_ratio": 0.0, "density": RHO})  # fmt: skip
    simulator = Simulator(robot, contact="none")
    simulator.step(effort=[0.0])
    # in one step of 10 ms the elastic wave (0.3 m/s) has not reached the tip
    assert simulator.state.v[2::3].min() == pytest.approx(-G * robot.h, rel=0.02)


@pytest.mark.slow
def test_bending_frequency_of_a_plucked_beam() -> None:
    mesh = box_mesh(SIZE, (20, 2, 2))
    material = {"young_modulus": E, "poisson_ratio": 0.0, "density": RHO}
    loaded = beam_robot(mesh, SIZE, gravity=[0.0, 0.0, -0.05 * G], material=material)
    held = Simulator(loaded, contact="none")
    assert held.settle(effort=[0.0]).converged
    free = beam_robot(
        mesh, SIZE, material=material, controller={"rate": 4000.0}, gravity=[0.0, 0.0, 0.0]
    )
    simulator = Simulator(free, contact="none")
    simulator.start_from(held.state)
    height = []
    for _ in range(1600):
        simulator.step(effort=[0.0])
        height.append(simulator.effector[0, 2] - 0.5 * SIDE)
    crossing = np.flatnonzero(np.diff(np.sign(height)) != 0)
    measured = 0.5 / (np.diff(crossing).mean() * free.h)
    # its own sag gives the stiffness of this mesh; 1.8751 is the first root of the cantilever
    stiffness_ratio = sag(2, 0.01 * G) / (
        RHO * 0.01 * G * SIDE**2 * LENGTH**4 / (8 * E * SIDE**4 / 12)
    )
    theory = 1.8751**2 / (2 * np.pi * LENGTH**2) * np.sqrt(E * SIDE**2 / (12 * RHO))
    assert measured == pytest.approx(theory / np.sqrt(stiffness_ratio), rel=0.03)


def test_energy_never_grows_without_input() -> None:
    mesh = box_mesh(SIZE, (8, 2, 2))
    robot = beam_robot(mesh, SIZE, controller={"rate": 500.0})
    simulator = Simulator(robot, contact="none")
    rng = np.random.default_rng(0)
    v = 0.5 * rng.standard_normal(robot.n)
    simulator.start_from(State(simulator.state.q, v))
    kinetic = [0.5 * float(robot.body.tetrahedra.mass @ v**2)]
    for _ in range(60):
        simulator.step(effort=[0.0])
        kinetic.append(0.5 * float(robot.body.tetrahedra.mass @ simulator.state.v**2))
    assert max(kinetic[1:]) < kinetic[0]
    assert kinetic[-1] < 0.2 * kinetic[0]  # implicit Euler damps what a step cannot resolve
