"""The gripper: two soft fingers on a palm, and the cube that they hold."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.robots.gallery import grid_cells, joined, write_mesh
from tauten.model.numerics import Array, Ints


@dataclass(frozen=True, slots=True)
class ForkShape:
    """Dimensions [m] and grid of the fingers; the origin lies on the axis about which the palm turns.

    Attributes:
        palm: x of the palm's two sides.
        tip: x of the ends of the fingers.
        gap: from finger to finger.
        thickness: of a finger.
        height: of palm and fingers.
        along: cells over the length of a finger.
        cube: edge of the cube.
    """

    palm: tuple[float, float] = (-0.045, -0.035)
    tip: float = -0.085
    gap: float = 0.026
    thickness: float = 0.007
    height: float = 0.016
    along: int = 10
    cube: float = 0.024


def block(x: tuple[float, float], y: Array, height: float, cells: int) -> tuple[Array, Ints]:
    """Nodes (n, 3) and hexahedra (c, 8) of a block around z = 0.

    Args:
        x: its ends [m].
        y: of its grid [m].
        height: of the block [m].
        cells: along x.
    """
    xs, zs = np.linspace(*x, cells + 1), np.linspace(-0.5, 0.5, 5) * height
    return grid_cells(np.stack(np.meshgrid(xs, y, zs, indexing="ij"), axis=-1))


def fork_cells(shape: ForkShape) -> tuple[Array, Ints]:
    """Nodes (n, 3) and hexahedra (c, 8) of palm and fingers."""
    side = 0.5 * shape.gap + np.linspace(0.0, shape.thickness, 3)  # (3,)
    across = np.concatenate([-side[::-1], np.linspace(-0.5, 0.5, 4)[1:-1] * shape.gap, side])
    fingers = [
        block((shape.tip, shape.palm[0]), y, shape.height, shape.along) for y in (side, -side[::-1])
    ]
    return joined([block(shape.palm, across, shape.height, 2), *fingers])


def make_fork(folder: Path) -> list[str]:
    """Write the meshes of fork and cube into a folder; returns lines about them."""
    shape = ForkShape()
    edge = np.linspace(-0.5, 0.5, 3) * shape.cube
    cube = grid_cells(np.stack(np.meshgrid(edge, edge, edge, indexing="ij"), axis=-1))
    return [
        write_mesh(folder / "fork.vtu", *fork_cells(shape)),
        write_mesh(folder / "cube.vtu", *cube),
    ]
