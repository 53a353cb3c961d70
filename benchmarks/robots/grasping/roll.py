"""The pad that rolls, and the ball that it rolls."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np

from benchmarks.robots.gallery import grid_cells, tetrahedra, write_mesh
from benchmarks.robots.grasping.push import box
from tauten.model.mesh import boundary_triangles
from tauten.model.numerics import Array, Ints


@dataclass(frozen=True, slots=True)
class RollShape:
    """Dimensions [m] and grids of a pad and of the ball below it, which lies on z = 0 at the pad's middle.

    Attributes:
        side: of the square pad.
        height: of the pad.
        cells: of the pad along x, y and z.
        radius: of the ball.
        arcs: edges over a quarter of a great circle of the ball.
    """

    side: float = 0.040
    height: float = 0.030
    cells: tuple[int, int, int] = (5, 5, 3)
    radius: float = 0.010
    arcs: int = 8


def ball_mesh(radius: float, arcs: int) -> tuple[Array, Ints]:
    """Nodes (n, 3) and tetrahedra (e, 4) of a ball around the origin: each joins a triangle and the centre.

    The surface is that of a cube, its grid at equal angles.

    Args:
        radius: of the ball [m].
        arcs: edges over a quarter of a great circle.
    """
    line = np.linspace(-1.0, 1.0, arcs + 1)
    nodes, cells = grid_cells(np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1))
    surface, triangles = np.unique(
        boundary_triangles(tetrahedra(nodes, cells)), return_inverse=True
    )
    places = np.tan(0.25 * np.pi * nodes[surface])
    places *= radius / np.linalg.norm(places, axis=1, keepdims=True)
    outside = triangles.reshape(-1, 3)
    centre = np.full(len(outside), len(surface))
    return np.vstack([places, np.zeros((1, 3))]), np.column_stack([outside, centre])


def make_roll(folder: Path) -> list[str]:
    """Write the meshes of pad and ball into a folder; returns lines about them."""
    shape = RollShape()
    half, low = 0.5 * shape.side, 2.0 * shape.radius
    lower, upper = np.array([-half, -half, low]), np.array([half, half, low + shape.height])
    nodes, tets = ball_mesh(shape.radius, shape.arcs)
    meshio.write(folder / "ball.vtu", meshio.Mesh(nodes, [("tetra", tets)]))
    return [
        write_mesh(folder / "pad.vtu", *box(lower, upper, shape.cells)),
        f"{folder / 'ball.vtu'}: {len(nodes)} nodes, {len(tets)} tetrahedra",
    ]
