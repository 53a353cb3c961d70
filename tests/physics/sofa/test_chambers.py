"""Chambers of SoftRobots: the inverse along SOFA's curve, and robots that SOFA gives no curve of.

Equilibria of these are put into the equations of SOFA, written plainly: forces of the elements, of the
pressure on the surface that SOFA maps into them, and of the cables add up to nothing.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sofa_robots import port
from support.robots.sofa_robots import pneumatic_finger, robots_folder
from support.sofa.elements import MM, cable_forces, corotational_forces, pressure_forces

from tauten.controller import Controller, ControllerSettings, Status
from tauten.model import Robot, Simulator
from tauten.model.mesh import MeshError, checked
from tauten.model.numerics import Array, Ints
from tauten.model.tetra import NodalBody

BALANCE = 1e-5  # of the largest force on a node; a surface of other triangles is out by 2e-2
SOFAS_ERROR = 0.03 * MM  # m, the least that SOFA's inverse of the diamond leaves
slow = pytest.mark.slow


@pytest.fixture(scope="module")
def data(reference: Path) -> Path:
    return robots_folder(reference, "accordion_model.npz")


@pytest.fixture(scope="module")
def inflated(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Robot[NodalBody]:
    robot = port(data, tmp_path_factory.mktemp("pneunets"), "pneunets")
    assert isinstance(robot.body, NodalBody)
    return robot


@pytest.fixture(scope="module")
def bellows(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Robot[NodalBody]:
    robot = port(data, tmp_path_factory.mktemp("accordion"), "accordion")
    assert isinstance(robot.body, NodalBody)
    return robot


def mapped(x: Array, model: Any, name: str) -> Array:
    """The points NAME of a model at node positions x (n_nodes, 3)."""
    nodes = model["tets"][model[f"{name}_tet"]]
    points: Array = np.einsum("pj,pji->pi", model[f"{name}_w"], x[nodes])
    return points


def add_mapped(forces: Array, model: Any, name: str, on_points: Array) -> None:
    """Add forces (p, 3) on the points NAME to those on the nodes (n_nodes, 3)."""
    nodes, weights = model["tets"][model[f"{name}_tet"]], model[f"{name}_w"]
    np.add.at(forces, nodes, weights[:, :, None] * on_points[:, None])


def imbalance(
    x: Array, model: Any, young: Array, pressure: float, efforts: Array
) -> tuple[float, float]:
    """Largest force on nodes x (n_nodes, 3) that nothing holds, in SOFA's equations, and of elements [N]."""
    tets: Ints = model["tets"].astype(np.int64)
    elastic = corotational_forces(x, MM * model["nodes"], tets, young, 0.3)
    forces, largest = elastic.copy(), np.abs(elastic).max()
    inside = pressure_forces(mapped(x, model, "cavity"), model["cavity_triangles"], pressure)
    add_mapped(forces, model, "cavity", inside)
    for i, effort in enumerate(efforts):
        route = np.vstack([MM * model["pull"][i], mapped(x, model, f"cable{i + 1}")])
        add_mapped(forces, model, f"cable{i + 1}", cable_forces(route, effort)[1:])
    forces[model["fixed"]] = 0.0
    return float(np.abs(forces).max()), float(largest)


@pytest.mark.parametrize(
    "pressure", [2e3, pytest.param(500.0, marks=slow), pytest.param(3.4e3, marks=slow)]
)
def test_the_pneunets_are_in_equilibrium_in_sofas_equations(
    data: Path, inflated: Robot[NodalBody], pressure: float
) -> None:
    """Up to the pressure at which the sliver of this mesh turns inside out."""
    model, robot = np.load(data / "pneunets_model.npz"), inflated
    simulator = Simulator(robot, "none")
    assert simulator.settle(effort=[pressure], tolerance=1e-10).converged
    tets = model["tets"].tolist()
    young = np.where([sorted(tet) == sorted(model["stiff_tets"][0]) for tet in tets], 300e3, 100e3)
    x = robot.body.nodes(simulator.state)[: len(model["nodes"])]
    left, largest = imbalance(x, model, young, pressure, np.zeros(0))
    assert left < BALANCE * largest


def test_the_sliver_of_the_pneunets_inverts_where_it_does_in_sofa(
    inflated: Robot[NodalBody],
) -> None:
    """From 3.5 kPa on; equilibria go on beyond it."""
    robot = inflated
    simulator = Simulator(robot, "none")
    for pressure, inverted in ((3.4e3, 0), (4e3, 1), (7e3, 1)):
        assert simulator.settle(effort=[pressure]).converged
        assert robot.body.inverted(simulator.state) == inverted


def test_the_mesh_of_the_accordion_is_refused(data: Path) -> None:
    model = np.load(data / "accordion_model.npz")
    with pytest.raises(
        MeshError, match=r"accordion: 384 pairs of .* 307 and 5851, lie on the same side .*repair"
    ):
        checked(MM * model["nodes"], model["tets"].astype(np.int64), "accordion")


# no segment of a cable becomes shorter than half of what it is at rest, below which its length is rounded
LOADS = [
    ([1e-3, 0.0, 0.0], 2e3),
    pytest.param([0.0, 8e-4, 0.0], -3e3, marks=slow),
    pytest.param([4e-4, 0.0, 7e-4], 1e4, marks=slow),
]


@pytest.mark.parametrize(("position", "pressure"), LOADS)
def test_the_accordion_is_in_equilibrium_in_sofas_equations(
    data: Path, bellows: Robot[NodalBody], position: list[float], pressure: float
) -> None:
    model, robot = np.load(data / "accordion_model.npz"), bellows
    simulator = Simulator(robot, "none")
    given = [*position, np.nan], [np.nan] * 3 + [pressure]
    assert simulator.settle(*given, tolerance=1e-10).converged
    x = robot.body.nodes(simulator.state)[: len(model["nodes"])]
    young = np.full(len(model["tets"]), 500e3)
    left, largest = imbalance(x, model, young, pressure, simulator.effort[:3])
    assert largest > 0.004  # N
    assert left < 4e-11 * max(1.0, abs(pressure) / 2e3)  # N


def follow(robot: Robot[NodalBody], target: Array) -> tuple[Array, Array]:
    """Where a quasi-static controller comes to rest: effector (3,) and efforts (n_a,)."""
    robot = robot.with_integration(replace(robot.integration, static=True))
    controller = Controller(robot, settings=ControllerSettings(regularisation=1e-5))
    before = controller.effector[0]
    for _ in range(100):
        actuation = controller.step(target)
        assert actuation.status is Status.OK
        moved, before = np.abs(controller.effector[0] - before).max(), controller.effector[0]
        if moved < 1e-8:  # m
            break
    return before, actuation.effort


@pytest.mark.parametrize(("position", "pressure"), LOADS)
def test_the_inverse_of_the_accordion_reaches_what_can_be_reached(
    bellows: Robot[NodalBody], position: list[float], pressure: float
) -> None:
    """Three cables and a chamber for three coordinates of its top."""
    robot = bellows
    simulator = Simulator(robot, "none")
    assert simulator.settle([*position, np.nan], [np.nan] * 3 + [pressure]).converged
    reached, _ = follow(robot, simulator.effector)
    assert np.linalg.norm(reached - simulator.effector[0]) < SOFAS_ERROR


@pytest.mark.long
@pytest.mark.parametrize("pressure", [3e3, pytest.param(1e3, marks=slow)])
def test_the_inverse_of_the_pneunets_finds_the_pressure(
    inflated: Robot[NodalBody], pressure: float
) -> None:
    simulator = Simulator(inflated, "none")
    assert simulator.settle(effort=[pressure]).converged
    reached, found = follow(inflated, simulator.effector)
    assert np.linalg.norm(reached - simulator.effector[0]) < SOFAS_ERROR
    assert found[0] == pytest.approx(pressure, rel=1e-3)


@pytest.mark.parametrize("state", [10, pytest.param(25, marks=slow), pytest.param(3, marks=slow)])
def test_the_inverse_of_the_pneumatic_finger_finds_sofas_pressure(data: Path, state: int) -> None:
    """SOFA's tip is the target, 26 states of 4 kPa each."""
    row = np.genfromtxt(data / "gripperfinger_fpolar.csv", delimiter=",", names=True)[state]
    target = MM * np.array([row[f"tip_{axis}"] for axis in "xyz"])
    reached, found = follow(pneumatic_finger(data), target)
    assert np.linalg.norm(reached - target) < SOFAS_ERROR
    assert found[0] == pytest.approx(1e3 * row["pressure_kPa"], rel=1e-3)
