"""The ring: a band of silicone that stands on its outer side."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.robots.gallery import grid_cells, joined, write_mesh
from tauten.model.numerics import Array, Ints


@dataclass(frozen=True, slots=True)
class RingShape:
    """Dimensions [m] and grid of the band, whose axis is y; it stands on z = 0.

    Attributes:
        radius: outside.
        thickness: of the band.
        width: of the band.
        cells: round the ring, over width and thickness.
    """

    radius: float = 0.024
    thickness: float = 0.004
    width: float = 0.020
    cells: tuple[int, int, int] = (32, 2, 2)


def ring_cells(shape: RingShape) -> tuple[Array, Ints]:
    """Nodes (n, 3) and hexahedra (c, 8) of the band."""
    around, across, through = shape.cells
    angle, y, depth = np.meshgrid(
        np.linspace(0.0, 2.0 * np.pi, around + 1),
        np.linspace(-0.5, 0.5, across + 1) * shape.width,
        np.linspace(0.0, shape.thickness, through + 1),
        indexing="ij",
    )
    radius = shape.radius - depth
    x, z = radius * np.sin(angle), shape.radius + radius * np.cos(angle)
    return joined([grid_cells(np.stack([x, y, z], axis=-1))])


def make_ring(folder: Path) -> list[str]:
    """Write the mesh into a folder; returns lines about it."""
    return [write_mesh(folder / "ring.vtu", *ring_cells(RingShape()))]
