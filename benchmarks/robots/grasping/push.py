"""The finger that pushes, and the block that it pushes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.robots.gallery import grid_cells, write_mesh
from tauten.model.numerics import Array, Ints


def box(lower: Array, upper: Array, cells: tuple[int, int, int]) -> tuple[Array, Ints]:
    """Nodes (n, 3) and hexahedra (c, 8) of a box.

    Args:
        lower: (3,) its corner with the smallest coordinates [m].
        upper: (3,) the opposite one [m].
        cells: along x, y and z.
    """
    lines = [np.linspace(a, b, n + 1) for a, b, n in zip(lower, upper, cells, strict=True)]
    return grid_cells(np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1))


def make_push(folder: Path) -> list[str]:
    """Write the meshes of finger and block into a folder; returns lines about them."""
    finger = box(np.array([-4e-3, -5e-3, 4e-3]), np.array([4e-3, 5e-3, 64e-3]), (2, 2, 15))
    block = box(np.full(3, -10e-3), np.full(3, 10e-3), (2, 2, 2))
    return [
        write_mesh(folder / "pusher.vtu", *finger),
        write_mesh(folder / "block.vtu", *block),
    ]
