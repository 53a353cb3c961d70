"""Elements against mechanics: patches, rigid motion, derivatives, energy."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.spatial.transform import Rotation
from support.robots.bodies import box_mesh

from tauten.model import make_pattern
from tauten.model.materials import COROTATIONAL, EXACT, MATERIAL, Law
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array
from tauten.model.tetra import linear_domains, lumped_mass, make_solid

LAME = (3e5, 2e5)  # Pa


def forces(mesh: TetMesh, x: Array, exact: bool) -> tuple[Array, sp.csc_array]:
    pattern = make_pattern(np.zeros(len(mesh.nodes), dtype=bool), [mesh.tets])
    domains = [linear_domains(mesh, np.zeros(len(mesh.tets), dtype=np.int64))]
    law = Law("of given constants", COROTATIONAL, (*LAME, 0.0, 0.0, 0.0), LAME)
    solid = make_solid(domains, [law], pattern, len(mesh.tets))
    assert solid.is_plain
    f, K = np.zeros_like(x), np.zeros(len(pattern.indices))
    solid.assemble(x, EXACT if exact else MATERIAL, f, K)
    return f, sp.csc_array((K, pattern.indices, pattern.indptr))


def irregular_box() -> TetMesh:
    mesh = box_mesh((0.1, 0.08, 0.06), (4, 3, 3))
    rng = np.random.default_rng(0)
    inside = np.all((mesh.nodes > 0.0) & (mesh.nodes < mesh.nodes.max(axis=0)), axis=1)
    nodes = mesh.nodes.copy()
    nodes[inside] += 2e-3 * rng.standard_normal((int(inside.sum()), 3))
    return TetMesh(nodes, mesh.tets)


def test_patch_of_constant_strain_is_in_balance_inside() -> None:
    mesh = irregular_box()
    stretch = np.eye(3) + 1e-2 * np.array([[1.0, 0.3, 0.0], [0.3, -0.5, 0.2], [0.0, 0.2, 0.4]])
    f, _ = forces(mesh, mesh.nodes @ stretch.T, exact=False)
    inside = np.all((mesh.nodes > 1e-9) & (mesh.nodes < mesh.nodes.max(axis=0) - 1e-9), axis=1)
    assert inside.sum() >= 8
    assert np.abs(f[inside]).max() < 1e-12 * np.abs(f).max()


def test_uniaxial_stretch_gives_hookes_force() -> None:
    mesh = box_mesh((0.1, 0.08, 0.06), (4, 3, 3))
    lam, mu = LAME
    E, nu = mu * (3 * lam + 2 * mu) / (lam + mu), lam / (2 * (lam + mu))
    strain = 1e-4
    f, _ = forces(mesh, mesh.nodes * (1 + strain * np.array([1.0, -nu, -nu])), exact=False)
    end = mesh.nodes[:, 0] > 0.1 - 1e-9
    assert f[end].sum(axis=0) == pytest.approx([-E * strain * 0.08 * 0.06, 0.0, 0.0], abs=1e-9)


def test_rigid_motion_makes_no_force() -> None:
    mesh = irregular_box()
    turn = Rotation.from_rotvec([0.5, 2.0, -1.0]).as_matrix()
    f, _ = forces(mesh, mesh.nodes @ turn.T + [0.3, -0.2, 0.1], exact=False)
    strained, _ = forces(mesh, 1.01 * mesh.nodes, exact=False)
    assert np.abs(f).max() < 1e-11 * np.abs(strained).max()


def test_forces_turn_with_the_body() -> None:
    mesh = irregular_box()
    x = mesh.nodes + 2e-3 * np.random.default_rng(1).standard_normal(mesh.nodes.shape)
    turn = Rotation.from_rotvec([-0.4, 1.0, 2.0]).as_matrix()
    f, _ = forces(mesh, x, exact=False)
    turned, _ = forces(mesh, x @ turn.T, exact=False)
    assert np.allclose(turned, f @ turn.T, atol=1e-10 * np.abs(f).max())


def test_internal_forces_balance() -> None:
    mesh = irregular_box()
    x = mesh.nodes + 3e-3 * np.random.default_rng(2).standard_normal(mesh.nodes.shape)
    f, _ = forces(mesh, x, exact=False)
    scale = np.abs(f).sum()
    assert np.abs(f.sum(axis=0)).max() < 1e-13 * scale
    assert np.abs(np.cross(x, f).sum(axis=0)).max() < 1e-13 * scale


def test_exact_tangent_is_the_derivative_at_large_deformation() -> None:
    mesh = irregular_box()
    rng = np.random.default_rng(3)
    x = mesh.nodes @ (np.eye(3) + 0.2 * rng.standard_normal((3, 3))).T
    x += 1e-3 * rng.standard_normal(x.shape)
    _, K = forces(mesh, x, exact=True)
    d, eps = rng.standard_normal(x.shape), 1e-8
    difference = -(forces(mesh, x + eps * d, True)[0] - forces(mesh, x - eps * d, True)[0]) / (
        2 * eps
    )
    assert np.allclose(
        (K @ d.ravel()).reshape(-1, 3), difference, atol=1e-7 * np.abs(difference).max()
    )
    assert abs(K - K.T).max() < 1e-12 * abs(K).max()


def test_held_rotation_tangent_is_exact_where_nothing_is_strained() -> None:
    mesh = irregular_box()
    x = mesh.nodes @ Rotation.from_rotvec([0.3, -1.0, 0.5]).as_matrix().T
    _, held = forces(mesh, x, exact=False)
    _, exact = forces(mesh, x, exact=True)
    assert abs(held - exact).max() < 1e-9 * abs(exact).max()


def test_tangent_of_held_rotations_is_positive_semidefinite() -> None:
    mesh = box_mesh((0.02, 0.02, 0.02), (2, 2, 2))
    x = mesh.nodes * [0.4, 1.2, 0.7]  # crushed so far that the exact tangent is indefinite
    for exact, definite in ((False, True), (True, False)):
        _, K = forces(mesh, x, exact)
        smallest = np.linalg.eigvalsh(K.toarray())[0]
        assert (smallest > -1e-10 * abs(K).max()) is np.bool_(definite)


def test_inverted_element_is_pushed_back() -> None:
    nodes = 1e-2 * np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    mesh = TetMesh(nodes, np.array([[0, 1, 2, 3]]))
    x = nodes.copy()
    x[3, 2] = -2e-3
    f, K = forces(mesh, x, exact=False)
    assert np.isfinite(f).all() and np.isfinite(K.data).all()
    assert f[3, 2] > 0.0


def test_lumped_mass_is_the_mass_of_the_body() -> None:
    mesh = irregular_box()
    assert lumped_mass(mesh, 1100.0).sum() == pytest.approx(1100.0 * 0.1 * 0.08 * 0.06)
