"""Viscous materials: creep and relaxation of a block, dissipation, rigid motion, robot files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.robots.bodies import beam_config, box_mesh

from tauten.model import Robot, Simulator, State
from tauten.model.load import build_robot
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig
from tauten.model.tetra import NodalBody
from tauten.reduction.state import StateBasisError, reducible

SIDE = 0.02  # m
E = 1e5  # Pa, without lateral contraction, so that a block under tension is one bar
STRESS = 1.0  # Pa, a strain of 1e-5
BLOCK = box_mesh((SIDE,) * 3, (4, 1, 1))


def block(
    viscosity: dict[str, object], rate: float, element: str = "linear", density: float = 1.0
) -> Robot[NodalBody]:
    """A block held at x = 0; by default it weighs next to nothing."""
    material = {
        "young_modulus": E, "poisson_ratio": 0.0, "density": density, "viscosity": viscosity
    }  # fmt: skip
    settings = beam_config((SIDE,) * 3, material=material, controller={"rate": rate})
    settings["mesh"] = {"file": "block.vtu", "element": element}
    return build_robot(RobotConfig.model_validate(settings), BLOCK, "block.toml")


def stretched(robot: Robot[NodalBody], strain: float) -> State:
    """The block under a uniform strain along x."""
    x = robot.body.mesh.nodes * [1.0 + strain, 1.0, 1.0]
    return State(x[robot.body.pattern.dof >= 0].ravel(), np.zeros(robot.n))


def pulled(robot: Robot[NodalBody], stress: float) -> Robot[NodalBody]:
    """The block under forces that cause a uniform tension."""
    load = -robot.forces(stretched(robot, stress / E))[0]
    held = replace(robot.body.tetrahedra, load=load)
    return replace(robot, body=replace(robot.body, tetrahedra=held))


def creep(robot: Robot[NodalBody], steps: int, converged: bool) -> tuple[Array, Array]:
    """Times (steps,) [s] and strains (steps,) of a block under STRESS from t = 0 on."""
    simulator = Simulator(pulled(robot, STRESS), contact="none")
    strains = []
    for _ in range(steps):
        assert simulator.step(effort=[0.0], converged=converged).converged
        strains.append((simulator.effector[0, 0] - SIDE) / SIDE)
    return np.arange(1, steps + 1) * robot.h, np.array(strains)


@pytest.mark.long
@pytest.mark.parametrize(
    ("element", "converged"),
    [
        ("linear", False),
        ("linear", True),
        pytest.param("smoothed", False, marks=pytest.mark.slow),
        pytest.param("smoothed", True, marks=pytest.mark.slow),
        pytest.param("quadratic", False, marks=pytest.mark.slow),
        pytest.param("quadratic", True, marks=pytest.mark.slow),
    ],
)
def test_kelvin_voigt_block_creeps_as_the_exact_solution(element: str, converged: bool) -> None:
    """ε = σ / E (1 − exp(−E t / η)), with η = 2 μ_v; the error of implicit Euler is of first order in h."""
    shear, errors = 5e3, []
    tau = 2.0 * shear / E  # 0.1 s
    for rate in (200.0, 800.0):
        robot = block({"shear_viscosity": shear}, rate, element)
        times, strains = creep(robot, round(0.3 * rate), converged)
        exact = STRESS / E * (1.0 - np.exp(-times / tau))
        errors.append(np.abs(strains - exact).max() * E / STRESS)
    assert errors[1] < 3e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.long
@pytest.mark.parametrize(
    "element", ["linear", pytest.param("quadratic", marks=pytest.mark.slow), "smoothed"]
)
def test_standard_linear_solid_creeps_as_the_exact_solution(element: str) -> None:
    """E ∥ (E₁ in series with E₁ τ): ε = σ / E (1 − E₁ / (E + E₁) exp(−t E / (τ (E + E₁))))."""
    share, tau = 1.5, 0.1
    robot = block({"shares": [share], "times": [tau]}, 2000.0, element)
    times, strains = creep(robot, 300, False)
    exact = STRESS / E * (1.0 - share / (1.0 + share) * np.exp(-times / (tau * (1.0 + share))))
    np.testing.assert_allclose(strains[5:], exact[5:], rtol=5e-3)


@pytest.mark.parametrize(
    ("viscosity", "lag", "tau"),
    [({"shear_viscosity": 5e3}, 1.0, 0.1), ({"shares": [1.5], "times": [0.1]}, 0.6, 0.25)],
    ids=["dashpot", "branch"],
)
def test_moves_creep_to_second_order(viscosity: dict[str, object], lag: float, tau: float) -> None:
    """The same exact solutions, ε E / σ = 1 − lag exp(−t / tau), in steps of second order."""
    errors, end = [], 0.28
    for rate in (25.0, 50.0, 100.0):
        simulator = Simulator(pulled(block(viscosity, rate), STRESS), contact="none")
        for _ in range(round(end * rate)):
            simulator.move(effort=[0.0])
        strain = (simulator.effector[0, 0] - SIDE) / SIDE
        errors.append(strain * E / STRESS - 1.0 + lag * np.exp(-end / tau))
    assert abs(errors[0]) < 2e-3
    np.testing.assert_allclose(np.divide(errors[:2], errors[1:]), 4.0, rtol=0.2)


def test_prony_series_relaxes_as_the_exact_solution() -> None:
    """The force of a body that is held: σ = E ε (1 + Σ g_i exp(−t / τ_i)), at rest the elastic law's."""
    shares, times = (0.5, 1.0), (0.02, 0.2)
    robot = block({"shares": shares, "times": times}, 1e4)
    rest = robot.rest()
    strain = 1e-5
    moved = stretched(robot, strain).q
    state = robot.advance(rest, (moved - rest.q) / robot.h, robot.h)
    top = np.abs(rest.q.reshape(-1, 3)[:, 0] - SIDE) < 1e-9
    for step in range(1, 3001):
        remembered, _ = robot.body.viscosity_at(state, robot.h)
        assert remembered is not None
        if step % 500 == 0:
            force = -(robot.forces(state)[0] + remembered).reshape(-1, 3)[top, 0].sum()
            decay = [
                g * np.exp(-(step + 1) * robot.h / t) for g, t in zip(shares, times, strict=True)
            ]
            exact = E * strain * (1.0 + sum(decay)) * SIDE**2
            assert force == pytest.approx(exact, rel=5e-3)
        state = robot.advance(state, np.zeros(robot.n), robot.h)


def wild(robot: Robot[NodalBody]) -> State:
    """A state far from rest in fast motion, with stresses in the branches."""
    generator, rest = np.random.default_rng(3), robot.rest()
    v = 2e-3 * generator.standard_normal(robot.n) / robot.h
    return replace(robot.advance(rest, v, robot.h), v=generator.standard_normal(robot.n))


MIXED = {"shear_viscosity": 20.0, "volume_viscosity": 10.0, "shares": [0.5], "times": [0.05]}


def damping_at(robot: Robot[NodalBody], state: State) -> Array:
    """C (n, n) of the viscosity at a state."""
    _, C = robot.body.viscosity_at(state, robot.h)
    assert C is not None
    pattern = robot.body.pattern
    dense = np.zeros((robot.n, robot.n))
    columns = np.repeat(np.arange(robot.n), np.diff(pattern.indptr))
    dense[pattern.indices, columns] = C
    return dense


@pytest.mark.parametrize("element", ["linear", "quadratic", "smoothed"])
def test_the_power_of_viscosity_is_that_of_the_strain_rate(element: str) -> None:
    """V (λ_v tr(E)² + 2 μ_v |E|²), here of E_11 = a, E_12 = b / 2, E_13 = c / 2."""
    shear, volume, (a, b, c) = 20.0, 30.0, (0.3, -0.2, 0.5)
    robot = block({"shear_viscosity": shear, "volume_viscosity": volume}, 100.0, element)
    rest = robot.rest()
    v = np.outer(rest.q.reshape(-1, 3)[:, 0], [a, b, c]).ravel()
    expected = volume * a * a + 2.0 * shear * (a * a + 0.5 * (b * b + c * c))
    assert v @ damping_at(robot, rest) @ v == pytest.approx(SIDE**3 * expected, rel=1e-9)


@pytest.mark.parametrize("element", ["linear", "quadratic", "smoothed"])
def test_viscous_forces_dissipate_and_rigid_motion_has_none(element: str) -> None:
    robot = block(MIXED, 100.0, element)
    state = wild(robot)
    dense = damping_at(robot, state)
    np.testing.assert_allclose(dense, dense.T, rtol=1e-10, atol=1e-12 * np.abs(dense).max())
    assert np.linalg.eigvalsh(dense)[0] > -1e-9 * np.abs(dense).max()
    # elements without fixed nodes: forces of a rotation about any axis vanish on nodes away from x = 0
    x = state.q.reshape(-1, 3)
    spin = np.cross([0.3, -0.7, 0.5], x).ravel()
    far = robot.rest().q.reshape(-1, 3)[:, 0] > 0.9 * SIDE
    force = (dense @ spin).reshape(-1, 3)[far]
    assert np.abs(force).max() < 1e-10 * np.abs(dense).max() * np.abs(spin).max()


@pytest.mark.parametrize("converged", [False, True])
def test_energy_falls_and_viscosity_takes_more_of_it(converged: bool) -> None:
    left = []
    for viscosity in ({"shear_viscosity": 1e-6}, MIXED):
        robot = block(viscosity, 2000.0, density=1000.0)
        simulator = Simulator(robot, contact="none")
        simulator.start_from(replace(robot.rest(), v=0.1 * wild(robot).v))
        energies = [robot.energy(simulator.state)]
        for _ in range(20):
            simulator.step(effort=[0.0], converged=converged)
            energies.append(robot.energy(simulator.state))
        assert np.diff(energies).max() < 1e-12 * energies[0]
        left.append(energies[3] / energies[0])
    assert left[1] < 0.9 * left[0]


def test_settling_relaxes_the_branches() -> None:
    """The equilibrium is the elastic law's, and a step from it stays there."""
    viscous, elastic = block(MIXED, 100.0), block({"shear_viscosity": 1.0}, 100.0)
    ends = []
    for robot in (viscous, elastic):
        simulator = Simulator(pulled(robot, 1e3), contact="none")
        assert simulator.settle(effort=[0.0]).converged
        at_rest = simulator.effector
        simulator.step(effort=[0.0])
        np.testing.assert_allclose(simulator.effector, at_rest, atol=1e-9)
        ends.append(at_rest)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-12)


def test_quasi_static_steps_leave_viscosity_out() -> None:
    """One is at the equilibrium of the elastic law."""
    robot = block(MIXED, 100.0)
    robot = robot.with_integration(replace(robot.integration, static=True))
    simulator = Simulator(pulled(robot, STRESS), contact="none")
    simulator.step(effort=[0.0])
    assert simulator.effector[0, 0] / SIDE - 1.0 == pytest.approx(STRESS / E, rel=1e-4)


def test_contact_bases_fit_whatever_the_viscosity() -> None:
    """They are made at rest."""
    elastic = build_robot(
        RobotConfig.model_validate(
            beam_config(
                (SIDE,) * 3, material={"young_modulus": E, "poisson_ratio": 0.0, "density": 1.0}
            )
        ),
        BLOCK,
        "block.toml",
    )
    assert block(MIXED, 100.0).digest == elastic.digest


@pytest.mark.parametrize(
    ("viscosity", "message"),
    [
        ({}, "needs shear_viscosity, volume_viscosity, or shares and times"),
        ({"shares": [0.1], "times": []}, "1 shares and 0 times"),
        ({"shares": [0.1], "times": [0.0]}, "greater than or equal to 0.000001"),
        ({"shear_viscosity": -1.0}, "greater than or equal to 0"),
    ],
)
def test_viscosities_that_are_none_are_refused(viscosity: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        block(viscosity, 100.0)


def test_state_reduction_refuses_viscous_materials() -> None:
    with pytest.raises(StateBasisError, match=r"leave out material\.viscosity"):
        reducible(block(MIXED, 100.0))
