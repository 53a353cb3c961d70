"""Chambers and volumes in quadratic elements, whose faces bulge between their nodes."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.bodies import CHAMBER, hollow_beam, pneumatic_robot

from tauten.model import Robot, State
from tauten.model.mesh import boundary_triangles
from tauten.model.numerics import Array, Ints
from tauten.model.tetra import NodalBody

VOLUME = {"name": "room", "kind": "volume", "inside": CHAMBER["inside"]}
FINE = 32  # parts of an edge of a face, of which flat triangles make a sum


def robot() -> Robot[NodalBody]:
    """A hollow beam; its root is held and not a part of the cavity."""
    return pneumatic_robot(mesh={"file": "balloon.vtu", "element": "quadratic"}, effectors=[VOLUME])


def wall() -> Array:
    """Corners of the faces of the cavity at rest, normals out of it: (f, 3, 3) [m]."""
    linear = hollow_beam()
    faces = linear.nodes[boundary_triangles(linear.tets)]
    lower, upper = np.array([0.009, 0.004, 0.009]), np.array([0.091, 0.016, 0.016])
    return faces[((faces > lower) & (faces < upper)).all(axis=(1, 2))][:, [0, 2, 1]]


def numbers(nodes: Array, points: Array) -> Ints:
    """Nodes at some points (p, 3)."""
    return np.array([np.abs(nodes - point).max(axis=1).argmin() for point in points])


def middles(faces: Array) -> Array:
    """Between the corners a, b and c: on ab, bc and ca (f, 3, 3)."""
    found: Array = 0.5 * (faces + faces[:, [1, 2, 0]])
    return found


def test_a_pressure_acts_on_the_nodes_as_shape_functions_say() -> None:
    """∫ N n dA of flat faces: a third of the area at the middle of each edge, nothing at the corners."""
    body, faces = robot(), wall()
    nodes = body.body.mesh.nodes
    area = 0.5 * np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])  # (f, 3)
    expected = np.zeros_like(nodes)
    for face, normal in zip(middles(faces), area, strict=True):
        expected[numbers(nodes, face)] += normal / 3.0
    rows = body.rows(body.rest(), contacts=False)
    free = body.body.pattern.dof >= 0
    for found in (rows.actuators, rows.effectors):
        np.testing.assert_allclose(
            found.dense().reshape(-1, 3), expected[free], atol=1e-9 * np.abs(expected).max()
        )


def bulging_volume(nodes: Array, faces: Ints) -> float:
    """Volume within quadratic faces (f, 6), corners and middles, by many flat triangles [m³]."""
    total = 0.0
    for i in range(FINE):
        for j in range(FINE - i):
            turns = [((i, j), (i + 1, j), (i, j + 1))]
            turns += [((i + 1, j), (i + 1, j + 1), (i, j + 1))] if i + j + 2 <= FINE else []
            for part in turns:
                v, w = np.array(part).T / FINE
                u = 1.0 - v - w
                shape = np.array(
                    [
                        u * (2 * u - 1),
                        v * (2 * v - 1),
                        w * (2 * w - 1),
                        4 * u * v,
                        4 * v * w,
                        4 * w * u,
                    ]
                )
                a, b, c = np.einsum("ks,fki->sfi", shape, nodes[faces])
                total += float(np.einsum("fi,fi->", a, np.cross(b, c))) / 6.0
    return total


def flat_volume(nodes: Array, faces: Ints) -> float:
    """Volume within four flat triangles for each quadratic face (f, 6) [m³]."""
    parts = nodes[faces[:, [[0, 3, 5], [1, 4, 3], [2, 5, 4], [3, 4, 5]]]].reshape(-1, 3, 3)
    return float(np.einsum("ti,ti->", parts[:, 0], np.cross(parts[:, 1], parts[:, 2]))) / 6.0


def test_the_volume_is_that_within_the_bulging_faces() -> None:
    """A pressure that acted on four flat triangles a face changed the volume by 7 % less."""
    body, faces = robot(), wall()
    rest, nodes = body.rest(), body.body.mesh.nodes
    places = np.concatenate([faces, middles(faces)], axis=1)  # (f, 6, 3)
    six = numbers(nodes, places.reshape(-1, 3)).reshape(-1, 6)
    moved = State(rest.q + 2e-5 * np.random.default_rng(0).standard_normal(body.n), rest.v)
    x = body.body.nodes(moved)
    change = bulging_volume(x, six) - bulging_volume(nodes, six)
    flat = flat_volume(x, six) - flat_volume(nodes, six)
    found = body.rows(moved, contacts=False).actuators.delta[0]
    assert abs(found - change) < 0.02 * abs(flat - change)
    assert body.effector_values(moved)[0] - body.effector_values(rest)[0] == pytest.approx(found)
