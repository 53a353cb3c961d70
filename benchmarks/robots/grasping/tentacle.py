"""The tentacle: a tapered strip that a cable winds round a post."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.robots.gallery import grid_cells, write_mesh
from tauten.model.numerics import Array, Ints


@dataclass(frozen=True, slots=True)
class TentacleShape:
    """Dimensions [m] and grid of the strip, which lies along x; its inner side is y = 0.

    Attributes:
        length: of the strip.
        thickness: at its base and at its tip.
        width: of the strip.
        cells: over length, thickness and width.
    """

    length: float = 0.135
    thickness: tuple[float, float] = (0.006, 0.004)
    width: float = 0.010
    cells: tuple[int, int, int] = (45, 2, 2)


def tentacle_cells(shape: TentacleShape) -> tuple[Array, Ints]:
    """Nodes (n, 3) and hexahedra (c, 8) of the strip."""
    along, through, across = shape.cells
    x, y, z = np.meshgrid(
        np.linspace(0.0, 1.0, along + 1),
        np.linspace(-1.0, 0.0, through + 1),
        np.linspace(-0.5, 0.5, across + 1),
        indexing="ij",
    )
    thickness = (1.0 - x) * shape.thickness[0] + x * shape.thickness[1]
    return grid_cells(np.stack([x * shape.length, y * thickness, z * shape.width], axis=-1))


def make_tentacle(folder: Path) -> list[str]:
    """Write the mesh into a folder; returns lines about it."""
    return [write_mesh(folder / "tentacle.vtu", *tentacle_cells(TentacleShape()))]
