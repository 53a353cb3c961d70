"""A thick-walled tube under internal pressure against Lamé's solution (Timoshenko and Goodier, 1970, §28)."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.solids import Kind, make_body

from benchmarks.robots.make_finger import split_cells
from tauten.model.materials import corotational
from tauten.model.mesh import TetMesh, boundary_triangles, oriented
from tauten.model.numerics import Array, Ints

INNER, OUTER, LENGTH = 0.01, 0.02, 0.005  # m
E = 1e6  # Pa
PRESSURE = 1.0  # Pa, displacements of 1e-6 of the radius


def quarter(radial: int, around: int) -> TetMesh:
    """A quarter of the tube, one cell long."""
    r = np.linspace(INNER, OUTER, radial + 1)
    angle = np.linspace(0.0, 0.5 * np.pi, around + 1)
    z = np.array([0.0, LENGTH])
    grid = np.stack(np.meshgrid(r, angle, z, indexing="ij"), axis=-1)
    radius, phi, height = np.moveaxis(grid.reshape(-1, 3), 1, 0)
    nodes: Array = np.stack([radius * np.cos(phi), radius * np.sin(phi), height], axis=1)
    numbers: Ints = np.arange(len(nodes)).reshape(grid.shape[:3])
    return TetMesh(nodes, oriented(nodes, split_cells(numbers, mirror_from=around)))


def lame(r: Array, nu: float) -> Array:
    """Radial displacement under internal pressure in plane strain [m]."""
    factor = PRESSURE * INNER**2 / (OUTER**2 - INNER**2) * (1.0 + nu) / E
    found: Array = factor * ((1.0 - 2.0 * nu) * r + OUTER**2 / r)
    return found


def pressure_load(nodes: Array, triangles: Ints) -> Array:
    """Nodal forces (n_nodes, 3) of the pressure on triangles, in equal thirds [N]."""
    corners = nodes[triangles]
    area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    centre = corners.mean(axis=1) * [1.0, 1.0, 0.0]
    outward = np.sign(np.einsum("ti,ti->t", area, centre))[:, None] * area
    load = np.zeros_like(nodes)
    np.add.at(load, triangles.ravel(), np.repeat(PRESSURE * outward / 3.0, 3, axis=0))
    return load


def displaced(kind: Kind, radial: int, nu: float) -> tuple[Array, Array]:
    """Radii (k,) and radial displacements (k,) of the nodes at z = 0 [m], from one linear solve."""
    mesh = quarter(radial, 2 * radial)
    body = make_body(mesh, kind, corotational(E, nu))
    nodes = body.mesh.nodes
    boundary = boundary_triangles(body.mesh.tets)
    radius = np.linalg.norm(nodes[:, :2], axis=1)
    # midpoints of straight edges lie a little inside of the circle
    inside = (radius[boundary] < INNER * 1.0001).all(axis=1)
    faces, weight = boundary[inside], 1.0
    if (
        kind == "quadratic"
    ):  # the consistent load of a face is on its midpoints, which a quarter of it joins
        faces, weight = faces[(faces >= len(mesh.nodes)).all(axis=1)], 4.0
    load = weight * pressure_load(nodes, faces)
    _, _, K = body.forces(nodes)
    # symmetry: no motion across x = 0, y = 0 and, in plane strain, along z
    fixed = np.stack([nodes[:, 0] < 1e-9, nodes[:, 1] < 1e-9, np.ones(len(nodes), dtype=bool)], 1)
    free = np.flatnonzero(~fixed.ravel())
    stiffness = K.toarray()[np.ix_(free, free)]
    u = np.zeros(3 * len(nodes))
    u[free] = np.linalg.solve(stiffness, load.ravel()[free])
    across = np.einsum("ni,ni->n", u.reshape(-1, 3)[:, :2], nodes[:, :2]) / radius
    chosen = (nodes[:, 2] < 1e-9) & (np.abs(nodes[:, 1]) < 1e-9)
    return radius[chosen], across[chosen]


@pytest.mark.parametrize("nu", [0.3, 0.45])
def test_displacements_of_the_wall_are_lames(nu: float) -> None:
    """Smoothed elements, within 2 % at every radius, and converging."""
    errors = []
    for radial in (4, 8):
        r, u = displaced("edge-node", radial, nu)
        errors.append(np.abs(u / lame(r, nu) - 1.0).max())
    assert errors[1] < 0.02
    assert errors[0] > 2.5 * errors[1]


def test_quadratic_elements_meet_lame_on_a_coarse_mesh() -> None:
    r, u = displaced("quadratic", 4, 0.45)
    np.testing.assert_allclose(u, lame(r, 0.45), rtol=0.02)
