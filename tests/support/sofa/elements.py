"""What SOFA computes with, written plainly: rotations of elements, and the points that it maps."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeAlias

import numpy as np
import pytest

from tauten.model.load import places as load_places
from tauten.model.materials import NO_TANGENT
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array, Bools, Ints
from tauten.model.points import NodePoints, combinations
from tauten.model.tetra.corotational import assemble_corotational

MM = 1e-3
Frames: TypeAlias = Callable[[Array, Ints], Array]  # of the elements (e, 3, 3), from positions


def polar_frames(x: Array, tets: Ints) -> Array:
    """SOFA's 'polar': the rotation nearest to the edges from the first corner."""
    U, _, Vt = np.linalg.svd(np.swapaxes(x[tets[:, 1:]] - x[tets[:, :1]], 1, 2))
    rotations: Array = U @ Vt
    return rotations


def large_frames(x: Array, tets: Ints) -> Array:
    """SOFA's 'large': the first edge, and the plane of the first two."""
    first, second = x[tets[:, 1]] - x[tets[:, 0]], x[tets[:, 2]] - x[tets[:, 0]]
    first /= np.linalg.norm(first, axis=1)[:, None]
    normal = np.cross(first, second)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return np.stack([first, np.cross(normal, first), normal], axis=2)


def assemble_with(frames: Frames, mesh: TetMesh):  # type: ignore[no-untyped-def]
    """`assemble_corotational`, small strain in frames of SOFA's that turn with the elements."""

    number = {tuple(sorted(tet)): e for e, tet in enumerate(mesh.tets.tolist())}

    def assemble(x, elements, tangent, slot, force, blocks, material):  # type: ignore[no-untyped-def]
        nodes, gradients, stiffness = elements
        if tangent == NO_TANGENT:
            return assemble_corotational(x, elements, tangent, slot, force, blocks, material)
        lam, mu = stiffness[:, :1], stiffness[:, 1:]  # times the volume
        tets = mesh.tets[[number[tuple(one)] for one in nodes.tolist()]]
        R = frames(x, tets) @ np.swapaxes(frames(mesh.nodes, tets), 1, 2)
        A = np.swapaxes(R, 1, 2) @ np.einsum("eai,eaj->eij", x[nodes], gradients)
        strain = 0.5 * (A + np.swapaxes(A, 1, 2)) - np.eye(3)
        trace = np.trace(strain, axis1=1, axis2=2)[:, None, None]
        P = R @ (2.0 * mu[..., None] * strain + lam[..., None] * trace * np.eye(3))
        np.add.at(force, nodes, -np.einsum("eij,eaj->eai", P, gradients))
        g = np.einsum("eij,eaj->eai", R, gradients)
        for pair, (a, b) in enumerate(zip(*np.triu_indices(4), strict=True)):
            block = lam[..., None] * np.einsum("ei,ej->eij", g[:, a], g[:, b])
            block += mu[..., None] * np.einsum("ei,ej->eij", g[:, b], g[:, a])
            dot = (g[:, a] * g[:, b]).sum(axis=1)
            block += mu[..., None] * dot[:, None, None] * np.eye(3)
            free = slot[:, pair] >= 0
            np.add.at(blocks, slot[free, pair], block[free].reshape(-1, 9))
            if len(material) > 0:
                np.add.at(material, slot[free, pair], block[free].reshape(-1, 9))
        return 0.0

    return assemble


@contextmanager
def points_as_in_sofa(model: Any, *names: str) -> Iterator[None]:
    """Robots that are built in it have points with the elements and weights of SOFA.

    A point outside the mesh is extrapolated from the element with the nearest centre there, and from the one
    with the nearest face here.

    Args:
        model: a `*_model.npz` of the reference data.
        names: of its points, `NAME_pts` or `NAME` with `NAME_tet` and `NAME_w`.
    """
    keys = [f"{name}_pts" if f"{name}_pts" in model else name for name in names]
    places = MM * np.concatenate([model[key] for key in keys])
    tets = model["tets"][np.concatenate([model[f"{name}_tet"] for name in names])]
    weights = np.concatenate([model[f"{name}_w"] for name in names])

    def attach(
        mesh: TetMesh, points: Array, what: str, max_outside: float, extrapolate_from: str, _: Bools
    ) -> NodePoints:
        apart = np.linalg.norm(places[:, None] - np.asarray(points)[None], axis=2)
        chosen = apart.argmin(axis=0)
        assert apart.min(axis=0).max() < 1e-9, what
        return combinations(tets[chosen].astype(np.int64), weights[chosen])

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(load_places, "attach", attach)
        yield


def corotational_forces(x: Array, rest: Array, tets: Ints, young: Array, poisson: float) -> Array:
    """Elastic forces (n_nodes, 3) [N] of linear tetrahedra with the rotation nearest to F.

    Args:
        x: (n_nodes, 3) positions [m].
        rest: (n_nodes, 3) positions without stress [m].
        tets: (e, 4) nodes.
        young: (e,) Young's moduli [Pa].
        poisson: Poisson's ratio.
    """
    edges = np.swapaxes(rest[tets[:, 1:]] - rest[tets[:, :1]], 1, 2)  # (e, 3, 3)
    volumes = np.linalg.det(edges) / 6.0
    moved = np.swapaxes(x[tets[:, 1:]] - x[tets[:, :1]], 1, 2)
    inverse = np.linalg.inv(edges)
    F = moved @ inverse
    U, _, Vt = np.linalg.svd(F)
    R = U @ Vt
    assert (np.linalg.det(R) > 0.0).all(), "an element is inverted"
    strain = np.swapaxes(R, 1, 2) @ F
    strain = 0.5 * (strain + np.swapaxes(strain, 1, 2)) - np.eye(3)
    mu = (0.5 * young / (1.0 + poisson))[:, None, None]
    lam = 2.0 * mu * poisson / (1.0 - 2.0 * poisson)
    P = R @ (
        2.0 * mu * strain + lam * np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    )
    corners = -volumes[:, None, None] * P @ np.swapaxes(inverse, 1, 2)  # (e, 3, corners 1 to 3)
    forces = np.zeros_like(x)
    np.add.at(forces, tets[:, 1:], np.swapaxes(corners, 1, 2))
    np.add.at(forces, tets[:, 0], -corners.sum(axis=2))
    return forces


def pressure_forces(x: Array, triangles: Ints, pressure: float) -> Array:
    """Forces (p, 3) [N] on the points (p, 3) of a closed surface, a third of each triangle's to each corner.

    Args:
        x: (p, 3) positions [m].
        triangles: (t, 3), normals into the material.
        pressure: [Pa].
    """
    a, b, c = (x[triangles[:, i]] for i in range(3))
    forces = np.zeros_like(x)
    np.add.at(forces, triangles, (pressure * np.cross(b - a, c - a) / 6.0)[:, None])
    return forces


def cable_forces(route: Array, effort: float) -> Array:
    """Forces (p, 3) [N] on the points of a cable (p, 3) [m], the first of which pulls it in."""
    along = np.diff(route, axis=0)
    along *= effort / np.linalg.norm(along, axis=1)[:, None]
    forces = np.zeros_like(route)
    forces[:-1] += along
    forces[1:] -= along
    return forces
