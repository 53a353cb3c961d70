"""Forces, pull points and contact of a surface with itself, of robots of beams alone."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.optimize import brentq
from support.robots.beam_robots import build, path_of_beams, rectangle
from support.robots.joined import push
from support.robots.short_arm import short_arm, write_short_arm

from tauten.model import Robot, Simulator, State, load_robot
from tauten.model.beams import BeamBody, bar
from tauten.model.numerics import Array

L, THIN, E, NU = 1.0, 0.01, 1e9, 0.3
SECTION = bar(2.0 * THIN, THIN)
EI, GJ = E * SECTION.bending[0], E / (2.0 * (1.0 + NU)) * SECTION.torsion


def column(folder: Path, count: int, **changes: object) -> Robot[BeamBody]:
    """A column along z that is clamped at its foot; it is thin along x."""
    nodes = np.outer(np.linspace(0.0, L, count + 1), [0.0, 0.0, 1.0])
    beams = path_of_beams(nodes, (1.0, 0.0, 0.0), "column")
    profile = rectangle("column", 2.0 * THIN, THIN)
    return build(folder, nodes, beams, [profile], (E, NU, 1000.0), [0], count, **changes)


def pushed(point: list[float], direction: list[float]) -> dict[str, object]:
    """The tables of a robot that is driven by one force."""
    return {"cables": [], "forces": [push("push", point, direction, max_outside=1.0)]}


def dense(robot: Robot[BeamBody], K: Array) -> Array:
    """CSC values as a matrix (n, n)."""
    full: Array = sp.csc_array((K, robot.body.pattern.indices, robot.body.pattern.indptr)).toarray()
    return full


def curved(robot: Robot[BeamBody]) -> State:
    """A state that is bent and turned, within a tenth of a radian a node."""
    rng = np.random.default_rng(2)
    return robot.advance(robot.rest(), rng.normal(scale=0.1, size=robot.n), 1.0)


def test_tangent_is_the_derivative_of_forces_and_pull_points(tmp_path: Path) -> None:
    """−∂(H_aᵀ λ_a)/∂q along random directions, of a force on a lever and a cable from outside."""
    tip = [0.0, 0.0, L]
    cable = {
        "name": "stay", "points": [tip], "pull_point": [0.4, -0.1, 0.1], "max_outside": 1.0,
        "max_tension": 100.0, "max_pull": 1.0, "max_rate": 1.0,
    }  # fmt: skip
    forces = [push("push", [0.1, 0.2, 1.1], [1.0, 2.0, -3.0], max_outside=1.0)]
    robot = column(tmp_path, 3, cables=[cable], forces=forces)
    state, effort, eps = curved(robot), np.array([7.0, -11.0]), 1e-6
    y = robot.effector(state)[0]
    away = np.linalg.norm(y - [0.4, -0.1, 0.1]) - np.linalg.norm(np.array(tip) - [0.4, -0.1, 0.1])
    rows = robot.rows(state).actuators
    assert rows.delta[0] == pytest.approx(-away, abs=1e-12), "the pull point stays where it is"
    plain, found = (robot.forces(state, lam, exact=True)[1] for lam in (None, effort))
    K = dense(robot, found - plain)

    def force(dq: Array) -> Array:
        at = robot.advance(state, dq, 1.0)
        result: Array = robot.rows(at, contacts=False).actuators.dense().T @ effort
        return result

    for d in np.random.default_rng(3).normal(size=(4, robot.n)):
        change = -d @ (force(eps * d) - force(-eps * d)) / (2.0 * eps)
        assert d @ K @ d == pytest.approx(change, rel=1e-5)


def test_force_beside_the_axis_bends_and_twists_a_cantilever(tmp_path: Path) -> None:
    """P L³ / 3 E I + P L / κ G A + P r² L / G J, with r from the axis to the force."""
    r, P = 0.2, 1e-3
    robot = column(tmp_path, 8, **pushed([0.0, r, L], [1.0, 0.0, 0.0]))
    simulator = Simulator(robot, "none")
    assert simulator.settle(effort=np.array([P]), tolerance=1e-12).converged
    shear = P * L / (SECTION.shear_area[1] * E / (2.0 * (1.0 + NU)))
    expected = P * L**3 / (3.0 * EI) + shear + P * r**2 * L / GJ
    moved = float(robot.rows(simulator.state).actuators.delta[0])
    assert moved == pytest.approx(expected, rel=6e-3)
    finer = column(tmp_path, 16, **pushed([0.0, r, L], [1.0, 0.0, 0.0]))
    simulator = Simulator(finer, "none")
    assert simulator.settle(effort=np.array([P]), tolerance=1e-12).converged
    closer = float(finer.rows(simulator.state).actuators.delta[0])
    assert abs(closer - expected) < 0.3 * abs(moved - expected) + 1e-4 * expected


def test_plans_count_on_the_stiffness_of_beams_without_load(tmp_path: Path) -> None:
    """A step that is longer than a tick: a column's tip yields to a force aside by L³ / 3 E I + L / κ G A.

    In a tick the tangent is the exact one, also beyond Euler's load.
    """
    robot = column(tmp_path, 16, **pushed([0.0, 0.0, L], [0.0, 0.0, -1.0]))
    euler, rest = np.pi**2 * EI / (4.0 * L**2), robot.rest()
    aside = np.eye(1, robot.n, robot.n - 6)[0]  # of the last node

    def flexibility(share: float) -> float:
        q, P = rest.q.reshape(-1, 7).copy(), share * euler
        q[:, 2] *= 1.0 - P / (E * SECTION.area)
        at = robot.body.assemble(State(q.ravel(), rest.v), np.array([P]))
        assert robot.body.system(at, robot.integration).exact
        system = robot.body.system(at, replace(robot.integration, rate=1e-3))
        return float(aside @ system.solve(aside)) * system.h**2

    shear = L / (SECTION.shear_area[1] * E / (2.0 * (1.0 + NU)))
    expected = L**3 / (3.0 * EI) + shear
    for share in (0.0, 0.08, 0.9, 1.1, -1.0):
        assert flexibility(share) == pytest.approx(expected, rel=6e-3)


def test_tangent_is_singular_where_a_force_on_a_rigid_mast_buckles_the_column(
    tmp_path: Path,
) -> None:
    """k a tan(k L) = 1 with k² = P / E I and the force a mast of length a above the column."""
    a, count = 0.3, 16
    robot = column(tmp_path, count, **pushed([0.0, 0.0, L + a], [0.0, 0.0, -1.0]))
    k = brentq(lambda k: k * a * np.tan(k * L) - 1.0, 0.1, 0.5 * np.pi - 1e-6)
    rest = robot.rest()

    def lowest(P: float) -> float:
        q = rest.q.reshape(-1, 7).copy()
        q[:, 2] *= 1.0 - P / (E * SECTION.area)
        _, K = robot.forces(State(q.ravel(), rest.v), np.array([P]), exact=True)
        return float(np.linalg.eigvalsh(dense(robot, K))[0])

    found = brentq(lowest, 0.5 * EI * k**2, 1.5 * EI * k**2, xtol=1e-6 * EI * k**2)
    assert found == pytest.approx(EI * k**2, rel=2e-3)


def test_force_over_the_length_bends_a_cantilever(tmp_path: Path) -> None:
    """By P L³ / 8 E I + P L / 2 κ G A at the tip, and by P L³ / 20 E I + P L / 3 κ G A on average."""
    P = 1e-3
    everywhere = push("push", [], [1.0, 0.0, 0.0]) | {"region": {"kind": "all"}}
    del everywhere["point"]
    robot = column(tmp_path, 16, cables=[], forces=[everywhere])
    simulator = Simulator(robot, "none")
    assert simulator.settle(effort=np.array([P]), tolerance=1e-12).converged
    shear = P * L / (SECTION.shear_area[1] * E / (2.0 * (1.0 + NU)))
    tip = P * L**3 / (8.0 * EI) + 0.5 * shear
    assert simulator.effector[0, 0] == pytest.approx(tip, rel=4e-3)
    mean = P * L**3 / (20.0 * EI) + shear / 3.0
    assert robot.rows(simulator.state).actuators.delta[0] == pytest.approx(mean, rel=4e-3)


def test_contact_of_a_surface_with_itself_is_that_of_its_parts(tmp_path: Path) -> None:
    """Ribs and discs as one surface of each joint against ribs and discs as two."""
    apart = short_arm(tmp_path)
    file = write_short_arm(tmp_path)
    network = json.loads((tmp_path / "manipulator.json").read_text())
    surfaces = {item["name"]: item for item in network["surfaces"]}
    for joint in "123":
        feet, disc = surfaces[f"feet{joint}"], surfaces.pop(f"disc{joint}")
        first = len(feet["points"])
        feet["triangles"] += [[first + i for i in corners] for corners in disc["triangles"]]
        feet["points"] += disc["points"]
        feet["nodes"] += disc["nodes"]
    network["surfaces"] = list(surfaces.values())
    (tmp_path / "manipulator.json").write_text(json.dumps(network))
    text = file.read_text()
    for joint in "123":
        text = text.replace(
            f'against = "disc{joint}"\npoints = 30', 'against = "itself"\npoints = 90'
        )
    file.write_text(text)
    folded = load_robot(file)
    tips, deepest = [], []
    for robot, contact in ((apart, "none"), (apart, "full"), (folded, "full")):
        simulator = Simulator(robot, contact)  # type: ignore[arg-type]
        assert simulator.settle(effort=np.array([80.0, 0.0, 0.0])).converged
        tips.append(simulator.effector[0])
        deepest.append(simulator.gaps.min())
    assert deepest[0] < -2e-4
    assert min(deepest[1:]) > -2e-6
    assert np.linalg.norm(tips[1] - tips[0]) > 10.0 * np.linalg.norm(tips[2] - tips[1])
