"""Structured tetrahedral meshes: grids of hexahedra, mapped, joined where they touch, cut into tetrahedra."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np

from tauten.model.mesh import oriented
from tauten.model.numerics import Array, Ints

# Corner c of a hexahedron lies at i = c & 1, j = c >> 1 & 1, k = c >> 2 & 1 of its grid.
_FACES = np.array(
    [[0, 2, 6, 4], [1, 3, 7, 5], [0, 1, 5, 4], [2, 3, 7, 6], [0, 1, 3, 2], [4, 5, 7, 6]]
)
_MERGED = 7  # decimals of a metre up to which nodes of two blocks are the same


def grid_cells(nodes: Array) -> tuple[Array, Ints]:
    """Nodes (m, 3) and hexahedra (c, 8) of a grid of nodes (a, b, c, 3)."""
    shape = nodes.shape[:3]
    numbers = np.arange(int(np.prod(shape))).reshape(shape)
    corners = [
        numbers[c & 1 : shape[0] - 1 + (c & 1), (c >> 1) & 1 : shape[1] - 1 + ((c >> 1) & 1),
                c >> 2 : shape[2] - 1 + (c >> 2)].ravel()
        for c in range(8)
    ]  # fmt: skip
    return nodes.reshape(-1, 3), np.stack(corners, axis=1)


def joined(parts: list[tuple[Array, Ints]]) -> tuple[Array, Ints]:
    """One mesh of several; nodes at the same place become one."""
    base = np.cumsum([0, *(len(nodes) for nodes, _ in parts)])
    points = np.concatenate([nodes for nodes, _ in parts])
    cells = np.concatenate([cells + b for (_, cells), b in zip(parts, base, strict=False)])
    places = np.round(points, _MERGED) + 0.0  # no negative zeros
    _, first, number = np.unique(places, axis=0, return_index=True, return_inverse=True)
    return points[first], number.ravel()[cells]


def used_cells(nodes: Array, cells: Ints) -> tuple[Array, Ints]:
    """Some hexahedra (c, 8) of a grid with the nodes that they have."""
    used, numbers = np.unique(cells, return_inverse=True)
    return nodes[used], numbers.reshape(-1, 8)


def tetrahedra(nodes: Array, cells: Ints) -> Ints:
    """Six tetrahedra for each hexahedron (c, 8), which fit those of its neighbours: (6 c, 4).

    Every face is cut along the diagonal through its node of the smallest number, so that both sides agree;
    the tetrahedra of a hexahedron join its node of the smallest number with the triangles of the three faces
    opposite (Dompierre and others 1999, without their case of five tetrahedra).
    """
    smallest = cells.argmin(axis=1)
    tets = []
    for corner in range(8):
        mine = cells[smallest == corner]  # (m, 8)
        for face in _FACES[np.all(corner != _FACES, axis=1)]:
            quad = mine[:, face]  # (m, 4) around the face
            turn = (quad.argmin(axis=1)[:, None] + np.arange(4)) % 4
            quad = np.take_along_axis(quad, turn, axis=1)
            tets += [np.stack([mine[:, corner], quad[:, 0], quad[:, k], quad[:, k + 1]], axis=1)
                     for k in (1, 2)]  # fmt: skip
    made: Ints = oriented(nodes, np.concatenate(tets))
    return made


def write_mesh(path: Path, nodes: Array, cells: Ints) -> str:
    """Write the tetrahedra of hexahedra; returns a line about them.

    Args:
        path: the mesh file.
        nodes: (n, 3) [m].
        cells: (c, 8) hexahedra.
    """
    nodes = nodes + 0.0  # no negative zeros
    tets = tetrahedra(nodes, cells)
    meshio.write(path, meshio.Mesh(nodes, [("tetra", tets)]))
    return f"{path}: {len(nodes)} nodes, {len(tets)} tetrahedra"


def disc(cells: int) -> Array:
    """A grid of nodes (cells + 1, cells + 1, 2) over the unit disc, from a square one.

    Lines of the grid keep their angles apart from the corners of the square, which come to lie on the circle
    (Fong 2015, the elliptical mapping).
    """
    u = np.linspace(-1.0, 1.0, cells + 1)
    x, y = np.meshgrid(u, u, indexing="ij")
    return np.stack([x * np.sqrt(1.0 - 0.5 * y**2), y * np.sqrt(1.0 - 0.5 * x**2)], axis=-1)
