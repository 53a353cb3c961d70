"""Viscous materials of robots with rigid regions, drives and glue: exact solutions, one mesh, energy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.robots.bodies import beam_robot, box_mesh
from support.robots.small_bodies import (
    END,
    FIRST,
    GLUE,
    LAST,
    MESH,
    MIDDLE,
    ROOT,
    RUBBER,
    SECOND,
    SIZE,
    SLIDE,
    TURN,
    constrained,
)

from tauten.model import Robot, Simulator
from tauten.model.constraints import ConstrainedBody
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array

SIDE, E = 0.02, 1e5  # m; Pa, without lateral contraction, so that a block under tension is one bar
MIXED = {"shear_viscosity": 20.0, "volume_viscosity": 10.0, "shares": [0.5], "times": [0.05]}


def pulled_block(viscosity: dict[str, object], rate: float, element: str) -> Robot[ConstrainedBody]:
    """A block of next to no weight, held at x = 0; a slider moves its other end. A rigid slice is inside."""
    slider = {
        "name": "slider", "motion": "translation", "axis": [1.0, 0.0, 0.0],
        "region": {"lower": [SIDE, 0.0, 0.0], "upper": [SIDE, SIDE, SIDE]},
        "max_travel": 0.1, "max_force": 100.0, "max_rate": 1e3,
    }  # fmt: skip
    middle = {"lower": [0.5 * SIDE, 0.0, 0.0], "upper": [0.5 * SIDE, SIDE, SIDE]}
    material = {"young_modulus": E, "poisson_ratio": 0.0, "density": 1.0, "viscosity": viscosity}
    return constrained(
        box_mesh((SIDE,) * 3, (4, 1, 1)), (SIDE,) * 3,
        mesh={"file": "block.vtu", "element": element}, material=material, drives=[slider],
        rigid=[{"name": "slice", "region": middle}], controller={"rate": rate},
    )  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize(
    ("element", "converged"),
    [
        ("linear", False),
        ("linear", True),
        ("smoothed", False),
        pytest.param("smoothed", True, marks=pytest.mark.slow),
    ],
)
def test_a_block_under_the_force_of_a_slider_creeps_as_the_exact_solution(
    element: str, converged: bool
) -> None:
    """ε = σ / E (1 − exp(−E t / η)), η = 2 μ_v; the error of implicit Euler is of first order in h."""
    shear, stress, errors = 5e3, 1.0, []
    for rate in (200.0, 800.0):
        robot = pulled_block({"shear_viscosity": shear}, rate, element)
        simulator, strains = Simulator(robot, contact="none"), []
        for _ in range(round(0.2 * rate)):
            report = simulator.step(effort=[0.0, stress * SIDE**2], converged=converged)
            assert report.converged
            strains.append(simulator.position[1] / SIDE)
        times = robot.h * np.arange(1, len(strains) + 1)
        exact = stress / E * (1.0 - np.exp(-times * E / (2.0 * shear)))
        errors.append(np.abs(strains - exact).max() * E / stress)
    assert errors[1] < 3e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.long
def test_the_force_of_a_slider_that_holds_relaxes_as_the_exact_solution() -> None:
    """σ = E ε (1 + Σ g_i exp(−t / τ_i)) after a jump, at rest the elastic law's."""
    shares, times = (0.5, 1.0), (0.02, 0.2)
    robot = pulled_block({"shares": shares, "times": times}, 2e3, "linear")
    simulator, strain = Simulator(robot, contact="none"), 1e-5
    for step in range(1, 501):
        simulator.step(position=[np.nan, strain * SIDE], effort=[0.0, np.nan])
        if step % 100 == 0:
            t = step * robot.h
            decay = [g * np.exp(-t / tau) for g, tau in zip(shares, times, strict=True)]
            exact = E * strain * (1.0 + sum(decay)) * SIDE**2
            assert simulator.effort[1] == pytest.approx(exact, rel=5e-3)


@pytest.mark.parametrize("converged", [False, True])
def test_a_viscous_glued_pair_moves_as_one_mesh(converged: bool) -> None:
    """Constraints that constrain nothing: the robot without them, memory included."""
    left = box_mesh((0.05, 0.02, 0.02), (3, 2, 2))
    right = TetMesh(left.nodes + np.array([0.05, 0.0, 0.0]), left.tets)
    nodes, inverse = np.unique(
        np.concatenate([left.nodes, right.nodes]).round(12), axis=0, return_inverse=True
    )
    inverse = inverse.ravel()
    tets = np.concatenate([inverse[left.tets], inverse[len(left.nodes) + right.tets]])
    whole, material = TetMesh(nodes, tets), {**RUBBER, "viscosity": {**MIXED, "shares": [2.0]}}
    face = {"body": "right", "lower": [0.05, 0.0, 0.0], "upper": [0.05, 0.02, 0.02]}
    pair = constrained(
        [left, right], mesh=None, fixed=[], material=material,
        bodies=[
            {"name": "left", "mesh": {"file": "a"}, "fixed": [ROOT]},
            {"name": "right", "mesh": {"file": "b"}},
        ],
        attachments=[{"kind": "glue", "region": face, "to": {"kind": "all", "body": "left"}}],
    )  # fmt: skip
    one = beam_robot(whole, SIZE, material=material)
    order = [int(np.linalg.norm(whole.nodes - x, axis=1).argmin()) for x in pair.body.mesh.nodes]
    simulators = [Simulator(robot, contact="none") for robot in (pair, one)]
    for _ in range(12):
        for simulator in simulators:
            assert simulator.step(effort=[8.0], converged=converged).converged
    first, second = (simulator.state for simulator in simulators)
    x = one.body.nodes(second)[order]
    assert np.abs(x - pair.body.mesh.nodes).max() > 5e-3, "it has bent far"
    assert np.abs(pair.body.nodes(first) - x).max() < 1e-7
    assert np.abs(first.memory).max() > 0.0
    assert pair.energy(first) == pytest.approx(one.energy(second), rel=1e-6)


def joined_bars(viscosity: dict[str, object]) -> Robot[ConstrainedBody]:
    """Two viscous bodies, glued, with a rigid plate, a servo and a slider."""
    return constrained(
        [MESH, MESH], mesh=None, fixed=[], bodies=[FIRST, SECOND],
        material={**RUBBER, "viscosity": viscosity}, attachments=[GLUE],
        rigid=[{"name": "plate", "region": {**END, "body": "first"}}],
        drives=[{**TURN, "region": MIDDLE}, {**SLIDE, "region": LAST}],
        controller={"rate": 2000.0},
    )  # fmt: skip


def energies(robot: Robot[ConstrainedBody], converged: bool) -> Array:
    """Energy [J] of a free motion of 20 steps from velocities at random."""
    simulator, v = Simulator(robot, contact="none"), np.zeros(robot.n)
    free = 3 * len(robot.body.coordinates.free)
    v[:free] = 0.1 * np.random.default_rng(3).standard_normal(free)
    simulator.start_from(replace(robot.rest(), v=v))
    found = [robot.energy(simulator.state)]
    for _ in range(20):
        simulator.step(effort=np.zeros(robot.n_a), converged=converged)
        found.append(robot.energy(simulator.state))
    return np.array(found)


@pytest.mark.long
@pytest.mark.parametrize("converged", [False, True])
def test_energy_falls_and_viscosity_takes_more_of_it(converged: bool) -> None:
    almost, viscous = (
        energies(joined_bars(one), converged) for one in ({"shear_viscosity": 1e-6}, MIXED)
    )
    assert max(np.diff(almost).max(), np.diff(viscous).max()) < 1e-12 * viscous[0]
    assert viscous[3] / viscous[0] < 0.9 * almost[3] / almost[0]


def test_viscous_forces_are_those_of_the_nodes() -> None:
    """Virtual power: vᵀ C v and vᵀ f in the coordinates are those of the unconstrained nodes with T v."""
    robot, rng = joined_bars(MIXED), np.random.default_rng(7)
    simulator = Simulator(robot, contact="none")
    for _ in range(10):
        simulator.step(effort=np.array([20.0, 0.01, 0.5]))
    state = simulator.state
    force, values = robot.body.viscosity_at(state, robot.h)
    assert force is not None
    assert values is not None
    v = rng.standard_normal(robot.n)
    positions, through = robot.body.placed(state)
    on_nodes = (robot.body.coordinates.matrix(through.T) @ v)[: robot.body.tetrahedra.m]
    held = robot.body.tetrahedra
    assert held.viscosity is not None
    raw_force, raw_C = held.viscous(held.viscosity, held.placed(positions), state.memory, robot.h)
    C, raw = robot.body.matrix(values), held.pattern.matrix(raw_C)
    assert v @ (C @ v) == pytest.approx(on_nodes @ (raw @ on_nodes), rel=1e-9)
    assert force @ v == pytest.approx(raw_force @ on_nodes, rel=1e-9)
    assert abs(force @ v) > 0.0


def test_settling_relaxes_the_branches() -> None:
    """The equilibrium is the elastic law's, and a step from it stays there."""
    ends = []
    for viscosity in (MIXED, {"shear_viscosity": 1.0}):
        simulator = Simulator(joined_bars(viscosity), contact="none")
        effort = np.array([5.0, 0.001, 0.05])
        assert simulator.settle(effort=effort).converged
        at_rest = simulator.effector
        simulator.step(effort=effort)
        np.testing.assert_allclose(simulator.effector, at_rest, atol=1e-8)
        ends.append(at_rest)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-9)
