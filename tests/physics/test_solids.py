"""Linear, quadratic and smoothed elements of any law: patches, derivatives, energy, locking."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.spatial.transform import Rotation
from support.robots.bodies import box_mesh
from support.robots.solids import Body, Kind, element_mesh, face_load, make_body

from tauten.model.materials import (
    EXACT,
    MATERIAL,
    NO_TANGENT,
    PROJECTED,
    Law,
    corotational,
    neo_hookean,
    stable_neo_hookean,
    yeoh,
)
from tauten.model.mesh import MeshError, QuadraticMesh, TetMesh, quadratic_mesh
from tauten.model.numerics import Array
from tauten.model.tetra import (
    quadratic_domains,
    quadratic_lumped_mass,
    smoothed_domains,
)

KINDS: list[Kind] = ["linear", "quadratic", "edge", "node", "edge-node"]
LAWS = [corotational(1e5, 0.4), stable_neo_hookean(1e5, 0.4), yeoh(9e4, 9e3, 0.0, 0.49)]
every_kind = pytest.mark.parametrize("kind", KINDS)
every_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)


def irregular_box() -> TetMesh:
    mesh = box_mesh((0.1, 0.08, 0.06), (3, 3, 3))
    rng = np.random.default_rng(0)
    inside = np.all((mesh.nodes > 1e-9) & (mesh.nodes < mesh.nodes.max(axis=0) - 1e-9), axis=1)
    nodes = mesh.nodes.copy()
    nodes[inside] += 3e-3 * rng.standard_normal((int(inside.sum()), 3))
    return TetMesh(nodes, mesh.tets)


def interior(nodes: Array) -> Array:
    inside: Array = np.all((nodes > 1e-9) & (nodes < nodes.max(axis=0) - 1e-9), axis=1)
    return inside


def deformed(body: Body, seed: int) -> Array:
    rng = np.random.default_rng(seed)
    x: Array = body.mesh.nodes @ (np.eye(3) + 0.2 * rng.standard_normal((3, 3))).T
    return x + 1e-3 * rng.standard_normal(x.shape)


@every_kind
@every_law
def test_patch_of_constant_gradient(kind: Kind, law: Law) -> None:
    """Any affine displacement leaves the inside in balance and has the energy volume x density."""
    body = make_body(irregular_box(), kind, law)
    F = np.eye(3) + np.array([[0.1, 0.3, 0.0], [-0.1, -0.15, 0.2], [0.0, 0.25, 0.2]])
    energy, f, _ = body.forces(body.mesh.nodes @ F.T)
    inside = interior(body.mesh.nodes)
    assert inside.sum() >= 8
    assert np.abs(f[inside]).max() < 1e-11 * np.abs(f).max()
    alone = make_body(box_mesh((0.01, 0.01, 0.01), (1, 1, 1)), "linear", law)
    density = alone.forces(alone.mesh.nodes @ F.T)[0] / 1e-6
    assert energy == pytest.approx(density * 0.1 * 0.08 * 0.06, rel=1e-11)


@every_kind
@every_law
def test_forces_are_the_derivative_of_the_energy(kind: Kind, law: Law) -> None:
    body = make_body(irregular_box(), kind, law)
    x, d = deformed(body, 1), np.random.default_rng(2).standard_normal(body.mesh.nodes.shape)
    step = 1e-7
    slope = (
        body.forces(x + step * d, NO_TANGENT)[0] - body.forces(x - step * d, NO_TANGENT)[0]
    ) / (2.0 * step)
    assert -(body.forces(x)[1] * d).sum() == pytest.approx(slope, rel=1e-6)


@every_kind
@every_law
def test_exact_tangent_is_the_derivative_of_the_forces(kind: Kind, law: Law) -> None:
    body = make_body(irregular_box(), kind, law)
    x, d = deformed(body, 3), np.random.default_rng(4).standard_normal(body.mesh.nodes.shape)
    _, _, K = body.forces(x)
    step = 1e-8
    slope = -(body.forces(x + step * d)[1] - body.forces(x - step * d)[1]) / (2.0 * step)
    difference = (K @ d.ravel()).reshape(-1, 3) - slope
    assert np.abs(difference).max() < 2e-6 * np.abs(slope).max()
    assert abs(K - K.T).max() < 1e-12 * abs(K).max()


@every_kind
@every_law
def test_projected_tangent_is_positive_semidefinite(kind: Kind, law: Law) -> None:
    body = make_body(box_mesh((0.02, 0.02, 0.02), (2, 2, 2)), kind, law)
    x = body.mesh.nodes * [0.3, 1.3, 0.7]
    x[interior(body.mesh.nodes)] *= [1.0, 1.0, -1.0]  # and some elements inside out
    smallest = {
        tangent: np.linalg.eigvalsh(body.forces(x, tangent)[2].toarray())[0]
        for tangent in (EXACT, PROJECTED)
    }
    largest = abs(body.forces(x, PROJECTED)[2]).max()
    assert smallest[EXACT] < -1e-3 * largest
    assert smallest[PROJECTED] > -1e-10 * largest


@pytest.mark.parametrize("kind", ["linear", "quadratic", "edge-node"])
def test_tangent_of_held_rotations_resists_strain_only(kind: Kind) -> None:
    """The spin of a stretched body costs energy with the square of the stretch, and of no other order."""
    body = make_body(box_mesh((0.02, 0.02, 0.02), (2, 2, 2)), kind, LAWS[0])
    power = []
    for strain in (0.1, 0.2):
        x = body.mesh.nodes * [1.0 + strain, 1.0, 1.0]
        spin = np.cross([0.0, 0.0, 1.0], x).ravel()
        K = body.forces(x, MATERIAL)[2]
        assert np.linalg.eigvalsh(K.toarray())[0] > -1e-10 * abs(K).max()
        power.append(spin @ (K @ spin))
    assert power[1] / power[0] == pytest.approx(4.0, rel=1e-6)


@every_kind
@every_law
def test_stiffness_of_the_material_at_rest_is_the_tangent(kind: Kind, law: Law) -> None:
    body = make_body(irregular_box(), kind, law)
    exact = body.forces(body.mesh.nodes, EXACT)[2]
    assert abs(body.forces(body.mesh.nodes, MATERIAL)[2] - exact).max() < 1e-9 * abs(exact).max()


@every_kind
@every_law
def test_one_pass_gives_both_tangents(kind: Kind, law: Law) -> None:
    """The stiffness of the material beside the exact tangent, as in a pass of its own."""
    body = make_body(irregular_box(), kind, law)
    x = deformed(body, 4)
    alone, (energy, f, K) = body.forces(x, MATERIAL)[2], body.forces(x, EXACT)
    force, values = np.zeros_like(x), np.zeros((2, K.nnz))
    both = body.solid.assemble(x, EXACT, force, values[0], values[1])
    assert both == energy
    np.testing.assert_array_equal(force, f)
    np.testing.assert_array_equal(values[0], K.data)
    np.testing.assert_allclose(values[1], alone.data, atol=1e-12 * np.abs(alone.data).max())


@every_kind
@pytest.mark.parametrize("law", LAWS[1:], ids=lambda law: law.name)
def test_damping_of_strained_bodies_resists_no_rigid_motion(kind: Kind, law: Law) -> None:
    body = make_body(irregular_box(), kind, law)
    x, rng = deformed(body, 5), np.random.default_rng(6)
    D = body.forces(x, MATERIAL)[2]
    rigid = np.cross(rng.standard_normal(3), x) + rng.standard_normal(3)
    assert np.abs(D @ rigid.ravel()).max() < 1e-12 * abs(D).max() * np.abs(rigid).max()
    smallest, largest = np.linalg.eigvalsh(D.toarray())[[0, -1]]
    assert smallest > -1e-12 * largest


@pytest.mark.parametrize("law", LAWS[1:], ids=lambda law: law.name)
def test_power_of_damping_is_that_of_the_rate_of_green_s_strain(law: Law) -> None:
    """Stretched to 1.3 and bent, with the strains of Green and Lagrange counted by finite differences."""
    body = make_body(box_mesh((0.03, 0.01, 0.01), (3, 1, 1)), "linear", law)
    X, rng, h = body.mesh.nodes, np.random.default_rng(7), 1e-5
    x = X * [1.3, 0.9, 0.9]
    x[:, 2] += 8.0 * X[:, 0] ** 2
    v = rng.standard_normal(x.shape) * 1e-3
    edges = X[body.mesh.tets[:, 1:]] - X[body.mesh.tets[:, :1]]  # (e, 3, 3)

    def strain(x: Array) -> Array:
        F = np.swapaxes(
            np.linalg.solve(edges, x[body.mesh.tets[:, 1:]] - x[body.mesh.tets[:, :1]]), 1, 2
        )
        return 0.5 * (np.swapaxes(F, 1, 2) @ F - np.eye(3))

    rate = (strain(x + h * v) - strain(x - h * v)) / (2.0 * h)
    lam, mu = law.lame
    power = lam * np.trace(rate, axis1=1, axis2=2) ** 2 + 2.0 * mu * (rate**2).sum(axis=(1, 2))
    expected = float(body.mesh.volumes @ power)
    found = v.ravel() @ (body.forces(x, MATERIAL)[2] @ v.ravel())
    assert found == pytest.approx(expected, rel=1e-6)


@every_kind
def test_rigid_motion_makes_no_force(kind: Kind) -> None:
    body = make_body(irregular_box(), kind, LAWS[1])
    turn = Rotation.from_rotvec([0.5, 2.0, -1.0]).as_matrix()
    energy, f, _ = body.forces(body.mesh.nodes @ turn.T + [0.3, -0.2, 0.1])
    strained, g, _ = body.forces(1.01 * body.mesh.nodes)
    assert np.abs(f).max() < 1e-10 * np.abs(g).max()
    assert abs(energy) < 1e-10 * strained


@pytest.mark.parametrize("kind", ["linear", "edge-node"])
@pytest.mark.parametrize("tangent", [EXACT, PROJECTED])
def test_corotational_elements_are_those_of_the_general_kernel(kind: Kind, tangent: int) -> None:
    body = make_body(irregular_box(), kind, corotational(1e5, 0.4))
    assert body.solid.stiffness is not None
    general = replace(body, solid=replace(body.solid, stiffness=None))
    x = deformed(body, 5)
    energy, f, K = body.forces(x, tangent)
    expected, force, matrix = general.forces(x, tangent)
    assert energy == pytest.approx(expected, rel=1e-12)
    assert np.allclose(f, force, atol=1e-12 * np.abs(f).max())
    assert np.allclose(K.data, matrix.data, atol=1e-11 * np.abs(K.data).max())


@pytest.mark.parametrize("kind", ["linear", "quadratic", "edge-node"])
@pytest.mark.parametrize("law", [*LAWS, neo_hookean(1e5, 0.45)], ids=lambda law: law.name)
def test_a_body_past_inversion_comes_back(kind: Kind, law: Law) -> None:
    mesh = box_mesh((0.03, 0.03, 0.03), (2, 2, 2))
    own = element_mesh(mesh, kind)
    body = make_body(mesh, kind, law, own.nodes[:, 0] < 1e-9)
    load = face_load(own, 0, 0.03, np.array([1e-5, 0.0, 0.0]) * law.young_modulus)
    expected, _ = body.equilibrium(load)
    corners = mesh.nodes + 0.007 * np.random.default_rng(7).standard_normal(mesh.nodes.shape)
    scattered = TetMesh(corners, mesh.tets)
    start = element_mesh(scattered, kind).nodes.copy()
    start[body.fixed] = own.nodes[body.fixed]
    assert (TetMesh(start, own.tets).volumes < 0.0).sum() >= 3
    found, _ = body.equilibrium(load, start=start)
    assert np.allclose(found, expected, atol=1e-7)


# --- locking -------------------------------------------------------------------------------------

LENGTH, SIDE = 0.1, 0.01  # of a cantilever


def cantilever_deflection(kind: Kind, law: Law, cells: int) -> float:
    """Deflection at the end over that of Timoshenko's beam."""
    mesh = box_mesh((LENGTH, SIDE, SIDE), (10 * cells, cells, cells))
    own = element_mesh(mesh, kind)
    body = make_body(mesh, kind, law, own.nodes[:, 0] < 1e-9)
    E, I, force = law.young_modulus, SIDE**4 / 12.0, 1e-6 * law.young_modulus * SIDE  # noqa: E741
    x, _ = body.equilibrium(face_load(own, 0, LENGTH, np.array([0.0, 0.0, force])))
    end = own.nodes[:, 0] > LENGTH - 1e-9
    shear = force * LENGTH / (5.0 / 6.0 * law.lame[1] * SIDE**2)
    theory = force * LENGTH**3 / (3.0 * E * I) + shear
    return float((x - own.nodes)[end, 2].mean() / theory)


# Least share of the deflection that must be found with two cells over the height
BENDING = {
    ("quadratic", 0.3): 0.98, ("quadratic", 0.45): 0.96, ("quadratic", 0.49): 0.94,
    ("quadratic", 0.499): 0.93, ("edge-node", 0.3): 0.98, ("edge-node", 0.45): 0.93,
    ("edge-node", 0.49): 0.86, ("edge-node", 0.499): 0.70,
}  # fmt: skip


@pytest.mark.parametrize(("kind", "nu"), BENDING)
def test_cantilever_does_not_lock(kind: Kind, nu: float) -> None:
    ratio = cantilever_deflection(kind, neo_hookean(1e6, nu), 2)
    assert BENDING[kind, nu] < ratio < 1.02
    assert cantilever_deflection("linear", neo_hookean(1e6, nu), 2) < 0.52


@pytest.mark.slow
def test_smoothed_cantilever_converges_where_linear_elements_lock() -> None:
    law = neo_hookean(1e6, 0.499)
    assert cantilever_deflection("edge-node", law, 4) > 0.94
    assert cantilever_deflection("linear", law, 4) < 0.06


def cook_membrane(cells: int, thickness: float) -> TetMesh:
    """Cook's tapered panel, 48 wide, 44 high at the left, 16 at the right, in mm."""
    mesh = box_mesh((1.0, 1.0, 1.0), (cells, cells, 1))
    u, v, w = mesh.nodes.T
    low, high = 44.0 * u, 44.0 + 16.0 * u
    nodes = np.stack([48.0 * u, low + v * (high - low), thickness * w], axis=1)
    return TetMesh(1e-3 * nodes, mesh.tets)


@pytest.mark.parametrize(
    ("kind", "cells", "tolerance"), [("quadratic", 8, 0.015), ("edge-node", 16, 0.03)]
)
def test_cooks_membrane(kind: Kind, cells: int, tolerance: float) -> None:
    """Plane stress, E = 1, ν = 1/3, unit load: 23.96 at the middle of the loaded edge (Simo and Rifai 1990).

    Thin and free at its faces, with a load so small that the strain is: displacements scale with it.
    """
    thickness = 1.0
    mesh = cook_membrane(cells, thickness)
    own = element_mesh(mesh, kind)
    body = make_body(mesh, kind, corotational(1e6, 1.0 / 3.0), own.nodes[:, 0] < 1e-9)
    # load F on the edge: v = 23.96 F / (E thickness), lengths cancel in plane problems
    force = 1e-5 * 1e6 * 1e-3 * thickness
    x, _ = body.equilibrium(face_load(own, 0, 0.048, np.array([0.0, force, 0.0])))
    middle = np.linalg.norm(own.nodes[:, :2] - [0.048, 0.052], axis=1) < 1e-9
    v = (x - own.nodes)[middle, 1].mean() / 1e-5
    assert v == pytest.approx(23.96, rel=tolerance)


# --- quadratic meshes ----------------------------------------------------------------------------


def test_quadratic_mass_is_positive_and_complete() -> None:
    mesh = quadratic_mesh(irregular_box())
    domains = quadratic_domains(mesh, np.zeros(len(mesh.tets), dtype=np.int64))
    mass = quadratic_lumped_mass(domains, np.full(len(mesh.tets), 1100.0), len(mesh.nodes))
    assert mass.min() > 0.0
    assert mass.sum() == pytest.approx(1100.0 * 0.1 * 0.08 * 0.06)
    assert mass @ mesh.nodes / mass.sum() == pytest.approx([0.05, 0.04, 0.03], abs=2e-3)


def test_curved_edges_give_the_volume_of_the_curved_body() -> None:
    """Mid-edge nodes of an octant's outer face on the sphere: nearer to its volume than the flat face."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    mesh = quadratic_mesh(TetMesh(corners, np.array([[0, 1, 2, 3]])))
    nodes = mesh.nodes.copy()
    outer = np.abs(nodes.sum(axis=1) - 1.0) < 1e-9
    nodes[outer] /= np.linalg.norm(nodes[outer], axis=1, keepdims=True)
    law = np.zeros(1, dtype=np.int64)
    curved = quadratic_domains(QuadraticMesh(nodes, mesh.tets), law).volumes.sum()
    flat = quadratic_domains(mesh, law).volumes.sum()
    octant = np.pi / 6.0
    assert flat == pytest.approx(1.0 / 6.0)
    assert abs(curved - octant) < 0.35 * abs(flat - octant)


def test_folded_quadratic_element_is_named() -> None:
    mesh = quadratic_mesh(box_mesh((0.01, 0.01, 0.01), (1, 1, 1)))
    nodes = mesh.nodes.copy()
    nodes[mesh.tets[3, 4]] += 2.0 * (nodes[mesh.tets[3, 3]] - nodes[mesh.tets[3, 4]])
    with pytest.raises(MeshError, match="folded over by their mid-edge nodes, the first is"):
        quadratic_domains(QuadraticMesh(nodes, mesh.tets), np.zeros(len(mesh.tets), dtype=np.int64))


def test_smoothed_domains_fill_the_body_and_keep_laws_apart() -> None:
    mesh = irregular_box()
    law = (mesh.nodes[mesh.tets].mean(axis=1)[:, 2] > 0.03).astype(np.int64)
    for around in ("edge", "node"):
        parts = smoothed_domains(mesh, law, around)
        for index in (0, 1):
            volume = sum(part.volumes[part.law == index].sum() for part in parts)
            assert volume == pytest.approx(mesh.volumes[law == index].sum())
            used = np.unique(np.concatenate([p.nodes[p.law == index].ravel() for p in parts]))
            assert np.array_equal(used, np.unique(mesh.tets[law == index]))


def test_smoothed_elements_have_no_motion_without_energy() -> None:
    """Only the six rigid motions are free at rest: node averages alone come close to more, edges do not."""
    body = make_body(box_mesh((0.03, 0.03, 0.03), (3, 3, 3)), "edge-node", LAWS[0])
    _, _, K = body.forces(body.mesh.nodes)
    values = np.linalg.eigvalsh(sp.csc_array(K).toarray())
    assert np.abs(values[:6]).max() < 1e-9 * values[-1]
    assert values[6] > 1e-3 * values[-1]
