"""Chambers with a surface of their own, whose triangles follow the elements that they lie in."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
import scipy.sparse as sp
from support.robots.bodies import (
    CHAMBER,
    HOLLOW_SIZE,
    box_mesh,
    pneumatic_config,
    pneumatic_robot,
    sphere_surface,
)

from tauten.model import Robot, Simulator, State
from tauten.model.load import build_robot
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array, Ints
from tauten.model.schema import RobotConfig, RobotFileError, validated
from tauten.model.tetra import NodalBody
from tauten.reduction.state.tetra.actuators import reduced_actuators
from tauten.reduction.state.tetra.body import ModeMotion

OWN = {**{name: value for name, value in CHAMBER.items() if name != "inside"},
       "stl": "air.stl", "own_surface": True}  # fmt: skip
RADIUS = 0.007  # m


def egg() -> tuple[Array, Ints]:
    """A closed surface within the beam, whose points are no nodes of it."""
    points, triangles = sphere_surface(1)
    return points * [0.03, RADIUS, RADIUS] + [0.05, 0.01, 0.01], triangles


def built(
    folder: Path, points: Array, triangles: Ints, body: TetMesh | None = None, **changes: object
) -> Robot[NodalBody]:
    """A beam, by default without a cavity, whose chamber has this surface."""
    meshio.write_points_cells(folder / "air.stl", points, [("triangle", triangles)])
    settings = pneumatic_config(
        chambers=[{**OWN, **changes}, {**CHAMBER, "name": "cavity"}][: 1 if body is None else 2]
    )
    config = validated(RobotConfig, settings, "balloon.toml")
    mesh = box_mesh(HOLLOW_SIZE, (10, 4, 4)) if body is None else body
    robot = build_robot(config, mesh, str(folder / "balloon.toml"))
    assert isinstance(robot.body, NodalBody)
    return robot


def deformed(robot: Robot[NodalBody]) -> State:
    rest = robot.rest()
    return State(rest.q + 1e-3 * np.random.default_rng(0).standard_normal(robot.n), rest.v)


def test_the_surface_of_the_cavity_gives_what_the_cavity_gives(tmp_path: Path) -> None:
    """As a file with the boundary of the mesh, beside a chamber with this boundary itself."""
    whole = pneumatic_robot()
    triangles = whole.actuator_set.chambers.nodes
    robot = built(tmp_path, whole.body.mesh.nodes, triangles, whole.body.mesh)
    state = deformed(robot)
    rows = robot.rows(state, contacts=False).actuators
    np.testing.assert_allclose(rows.delta[0], rows.delta[1], rtol=1e-9)
    np.testing.assert_allclose(*rows.dense(), atol=1e-9 * np.abs(rows.dense()).max())
    own, other = (robot.forces(state, lam, exact=True)[1] for lam in np.diag([2e4, 2e4]))
    np.testing.assert_allclose(own, other, atol=1e-9 * np.abs(other).max())
    assert np.abs(own - robot.forces(state, exact=True)[1]).max() > 1.0  # N/m
    simulators = [Simulator(one, contact="none") for one in (robot, whole)]
    assert simulators[0].settle(effort=[2e4, 0.0]).converged
    assert simulators[1].settle(effort=[2e4]).converged
    tips = [simulator.effector[0] for simulator in simulators]
    assert np.linalg.norm(tips[0] - robot.rows(robot.rest()).effectors.delta[:3]) > 5e-4
    np.testing.assert_allclose(*tips, atol=1e-8)


def test_rows_and_tangent_are_derivatives(tmp_path: Path) -> None:
    """Of a surface that cuts through elements."""
    robot = built(tmp_path, *egg())
    points, triangles = egg()
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    rest_volume = np.einsum("ti,ti->", a, np.cross(b, c)) / 6.0
    assert robot.actuator_set.chambers.rest_volume == pytest.approx([rest_volume])
    state, step, lam = deformed(robot), 1e-6, np.array([3e4])
    direction = np.random.default_rng(1).standard_normal(robot.n)

    def at(by: float) -> tuple[Array, Array]:
        moved = State(state.q + by * direction, state.v)
        rows = robot.rows(moved, contacts=False).actuators
        return rows.delta, robot.forces(moved)[0] + rows.H.T @ lam

    rows, (_, K) = robot.rows(state, contacts=False).actuators, robot.forces(state, lam, exact=True)
    slopes = [(up - down) / (2.0 * step) for up, down in zip(at(step), at(-step), strict=True)]
    np.testing.assert_allclose(slopes[0], rows.dense() @ direction, rtol=1e-6)
    tangent = sp.csc_array((K, robot.body.pattern.indices, robot.body.pattern.indptr))
    np.testing.assert_allclose(tangent @ direction, -slopes[1], atol=1e-6 * np.abs(slopes[1]).max())


def test_the_reduced_volume_is_that_of_the_full_model(tmp_path: Path) -> None:
    robot = built(tmp_path, *egg())
    Phi, _ = np.linalg.qr(np.random.default_rng(0).standard_normal((robot.n, 6)))
    alpha = np.array([2.0, -1.0, 3.0, 1.0, -2.0, 1.5]) * 1e-3
    full = robot.rows(State(robot.rest().q + Phi @ alpha, robot.rest().v), contacts=False).actuators
    reduced = reduced_actuators(robot.body, Phi).rows(ModeMotion(alpha, None, np.zeros(0)))
    np.testing.assert_allclose(reduced.delta, full.delta, rtol=1e-9)
    np.testing.assert_allclose(reduced.H, full.H @ Phi, atol=1e-9 * np.abs(reduced.H).max())


def test_the_surface_and_its_unit_are_part_of_the_digest(tmp_path: Path) -> None:
    points, triangles = egg()
    plain = built(tmp_path, points, triangles).digest
    assert built(tmp_path, points, triangles).digest == plain
    assert built(tmp_path, points + np.array([0.001, 0.0, 0.0]), triangles).digest != plain


def test_a_surface_that_is_inside_out_is_turned(tmp_path: Path) -> None:
    points, triangles = egg()
    turned = built(tmp_path, points, triangles[:, ::-1])
    assert turned.actuator_set.chambers.rest_volume[0] > 0.0


def test_a_surface_outside_the_mesh_needs_leave(tmp_path: Path) -> None:
    points, triangles = egg()
    out = points + np.array([0.0, 0.0, 0.005])  # 2 mm above the top
    with pytest.raises(RobotFileError, match=r"chambers\.bellows\.stl: point \d+ at .* outside"):
        built(tmp_path, out, triangles)
    robot = built(tmp_path, out, triangles, max_outside=3e-3)
    assert robot.actuator_set.chambers.rest_volume[0] > 0.0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stl": None, "inside": [0.0, 0.0, 0.0]}, "own_surface is given without stl"),
        ({"own_surface": False, "max_outside": 1e-3}, "max_outside is given without own_surface"),
    ],
)
def test_what_makes_no_own_surface_is_said(changes: dict[str, object], message: str) -> None:
    with pytest.raises(RobotFileError, match=message):
        validated(RobotConfig, pneumatic_config(chambers=[{**OWN, **changes}]), "balloon.toml")


def test_an_open_surface_is_refused(tmp_path: Path) -> None:
    points, triangles = egg()
    with pytest.raises(RobotFileError, match="is not closed: 3 edges"):
        built(tmp_path, points, triangles[1:])
