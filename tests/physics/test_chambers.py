"""Chambers against Lamé's sphere, a balloon past its limit point, SOFA's pneumatic finger, and work."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from support.robots.bodies import CABLE, hollow_sphere, pneumatic_robot
from support.robots.sofa_robots import pneumatic_finger

from tauten.model import Robot, Simulator
from tauten.model.mesh import boundary_triangles
from tauten.model.numerics import Array
from tauten.model.tetra import NodalBody

INNER, OUTER = 1e-2, 1.4e-2  # m
SHEAR_MODULUS = 1e5  # Pa
AIR = {"name": "air", "inside": [0.0, 0.0, 0.0], "max_pressure": 1e6, "max_volume_change": 1.0,
       "max_rate": 1.0}  # fmt: skip


def sphere(
    element: str, law: str, poisson_ratio: float, subdivisions: int, layers: int
) -> Robot[NodalBody]:
    """A hollow sphere that three nodes of its outside hold."""
    mesh = hollow_sphere(INNER, OUTER, subdivisions, layers)
    radius = np.linalg.norm(mesh.nodes, axis=1)
    faces = boundary_triangles(mesh.tets)
    face = faces[(radius[faces] > 0.999 * OUTER).all(axis=1)][0]
    lowest = mesh.nodes[mesh.nodes[:, 2].argmin()]
    young_modulus = 2.0 * SHEAR_MODULUS * (1.0 + poisson_ratio)
    return pneumatic_robot(
        mesh,
        mesh={"file": "sphere.vtu", "element": element},
        material={
            "young_modulus": young_modulus, "poisson_ratio": poisson_ratio, "density": 1e3,
            "law": law,
        },
        fixed=[{"lower": (x - 1e-7).tolist(), "upper": (x + 1e-7).tolist()} for x in mesh.nodes[face]],
        chambers=[AIR],
        effectors=[{"name": "pole", "point": lowest.tolist(), "max_outside": 1e-4}],
    )  # fmt: skip


def radii(robot: Robot[NodalBody]) -> tuple[float, float]:
    """Radii of the sphere whose cavity and whole body have the volumes of the mesh [m]."""
    hollow = float(robot.actuator_set.chambers.rest_volume[0])
    whole = hollow + float(robot.body.mesh.volumes.sum())
    return float(np.cbrt(0.75 * hollow / np.pi)), float(np.cbrt(0.75 * whole / np.pi))


@pytest.mark.parametrize(("element", "layers"), [("smoothed", 3), ("quadratic", 1)])
def test_a_thick_sphere_under_pressure_grows_as_lame_says(element: str, layers: int) -> None:
    """u(a) = p a / E · ((1 − 2ν) a³ + (1 + ν) b³ / 2) / (b³ − a³) (Timoshenko and Goodier, § 136)."""
    nu, pressure = 0.3, 100.0
    robot = sphere(element, "corotational", nu, 2, layers)
    simulator = Simulator(robot, "none")
    assert simulator.settle(effort=[pressure]).converged
    (a, b), E = radii(robot), 2.0 * SHEAR_MODULUS * (1.0 + nu)
    u = pressure * a / E * ((1.0 - 2.0 * nu) * a**3 + 0.5 * (1.0 + nu) * b**3) / (b**3 - a**3)
    assert simulator.position[0] == pytest.approx(4.0 * np.pi * a**2 * u, rel=0.01)


def balloon_pressure(growth: float, a: float, b: float) -> float:
    """Pressure in a neo-Hookean sphere that is incompressible, its cavity grown to a multiple [Pa].

    2 μ ∫ (λ⁻² + λ⁻⁵) dλ between the stretches of the outside and the inside (Green and Zerna, 1968).
    """
    inside = np.cbrt(growth)
    outside = np.cbrt(1.0 + (growth - 1.0) * (a / b) ** 3)
    near, far = (1.0 / x + 0.25 / x**4 for x in (outside, inside))
    return float(2.0 * SHEAR_MODULUS * (near - far))


def test_a_balloon_passes_its_limit_point_under_given_volume() -> None:
    robot = sphere("quadratic", "neo-hookean", 0.49, 1, 1)
    simulator, (a, b) = Simulator(robot, "none"), radii(robot)
    rest, pressures = robot.actuator_set.chambers.rest_volume[0], []
    for growth in (1.5, 2.0, 3.0, 4.0, 6.0, 8.0):
        assert simulator.settle(position=[(growth - 1.0) * rest]).converged
        assert simulator.position[0] == pytest.approx((growth - 1.0) * rest, rel=1e-6)
        pressures.append(simulator.effort[0])
        assert pressures[-1] == pytest.approx(balloon_pressure(growth, a, b), rel=0.02)
    assert np.argmax(pressures) == 3  # the largest pressure is at four times the volume


@pytest.mark.slow
def test_more_pressure_than_the_limit_point_has_no_equilibrium() -> None:
    simulator = Simulator(sphere("quadratic", "neo-hookean", 0.49, 1, 1), "none")
    report = simulator.settle(effort=[6e4], max_iterations=60)
    assert not report.converged
    assert 0.3 < report.share < 0.75  # of 60 kPa; the limit point is at 41 kPa


def test_the_pneumatic_finger_follows_the_curve_of_sofa(reference: Path) -> None:
    data = reference / "sofa_robots"
    if not (data / "gripperfinger_fpolar.csv").exists():
        pytest.skip("no reference data: set TAUTEN_REFERENCE_DATA")
    robot = pneumatic_finger(data)
    assert robot.actuator_set.chambers.rest_volume[0] == pytest.approx(8887.5e-9, rel=1e-9)
    simulator = Simulator(robot, "none")
    with (data / "gripperfinger_fpolar.csv").open() as file:
        states = list(csv.DictReader(file))
    for state in states[1::4]:
        assert simulator.settle(effort=[1e3 * float(state["pressure_kPa"])]).converged
        tip = np.array([float(state[f"tip_{axis}"]) for axis in "xyz"])  # mm
        np.testing.assert_allclose(1e3 * simulator.effector[0], tip, atol=1e-4)
        growth = float(state["volume_growth"])  # mm³
        assert 1e9 * simulator.position[0] == pytest.approx(growth, abs=0.01)


def elastic_energy(robot: Robot, simulator: Simulator) -> float:
    assert isinstance(robot.body, NodalBody)
    return robot.potential(simulator.state)


def test_the_work_of_all_actuators_is_the_energy_stored() -> None:
    """∫ λ dδ along a path of equilibria, by Simpson's rule, against the elastic energy at its end."""
    push = {"name": "push", "point": [0.1, 0.01, 0.01], "direction": [0.0, 1.0, 0.0],
            "max_force": 1.0, "max_travel": 0.1, "max_rate": 1.0}  # fmt: skip
    robot = pneumatic_robot(cables=[CABLE], forces=[push])
    simulator = Simulator(robot, "none")
    final, steps = np.array([0.003, 1.5e-6, 0.005]), 16
    positions, efforts = [np.zeros(3)], [np.zeros(3)]
    for step in range(1, steps + 1):
        assert simulator.settle(position=final * step / steps, tolerance=1e-9).converged
        positions.append(simulator.position)
        efforts.append(simulator.effort)
    np.testing.assert_allclose(positions[-1], final, rtol=1e-6)
    work = simpson(np.array(efforts) @ final / steps)
    assert work == pytest.approx(elastic_energy(robot, simulator), rel=2e-4)


def simpson(values: Array) -> float:
    """Integral of equally spaced values, an odd number of them, at a spacing of one."""
    return (
        float(values[0] + values[-1] + 4.0 * values[1:-1:2].sum() + 2.0 * values[2:-1:2].sum())
        / 3.0
    )


def test_a_sealed_chamber_resists_the_cable_that_squeezes_it() -> None:
    """An incompressible filling keeps its volume; pressure and stiffness rise."""
    robot = pneumatic_robot(cables=[CABLE])
    sealed, vented = Simulator(robot, "none"), Simulator(robot, "none")
    assert sealed.settle(position=[0.005, 0.0]).converged
    assert vented.settle(position=[0.005, np.nan], effort=[np.nan, 0.0]).converged
    assert abs(sealed.position[1]) < 1e-12
    assert vented.effort[1] == 0.0
    assert vented.position[1] < -1e-9 if sealed.effort[1] > 0.0 else vented.position[1] > 1e-9
    assert sealed.effort[0] > vented.effort[0] > 0.0


def test_vacuum_bends_the_other_way() -> None:
    robot = pneumatic_robot()
    simulator = Simulator(robot, "none")
    heights = []
    for pressure in (-2e3, 0.0, 2e3):
        assert simulator.settle(effort=[pressure]).converged
        heights.append(simulator.effector[0, 2])
    assert heights[0] > heights[1] > heights[2]
    assert heights[0] - heights[1] == pytest.approx(heights[1] - heights[2], rel=0.05)
