"""The crawler: a strip bent to two arches."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.robots.gallery import grid_cells, write_mesh
from tauten.model.numerics import Array, Ints


@dataclass(frozen=True, slots=True)
class CrawlerShape:
    """Dimensions [m] and grid of a strip bent to two arches, with a foot between them and one at each end.

    Attributes:
        pitch: from foot to foot.
        height: of the arches.
        thickness: of the strip.
        width: of the strip.
        cells: over length, width and thickness.
    """

    pitch: float = 0.040
    height: float = 0.012
    thickness: float = 0.003
    width: float = 0.016
    cells: tuple[int, int, int] = (40, 2, 2)


def crawler_cells(shape: CrawlerShape) -> tuple[Array, Ints]:
    """Nodes (n, 3) and hexahedra (c, 8) of the strip; the floor is z = 0, the middle foot at x = 0."""
    along, across, through = shape.cells
    x = np.linspace(-1.25, 1.25, along + 1) * shape.pitch
    y = np.linspace(-0.5, 0.5, across + 1) * shape.width
    depth = np.linspace(-0.5, 0.5, through + 1) * shape.thickness
    turn = 2.0 * np.pi * x / shape.pitch
    z = 0.5 * shape.thickness + 0.5 * shape.height * (1.0 - np.cos(turn))
    slope = 0.5 * shape.height * np.sin(turn) * 2.0 * np.pi / shape.pitch
    normal = np.stack([-slope, np.ones_like(slope)]) / np.hypot(1.0, slope)  # (2, a)
    nodes = np.zeros((along + 1, across + 1, through + 1, 3))
    nodes[..., 0] = x[:, None, None] + depth * normal[0][:, None, None]
    nodes[..., 1] = y[:, None]
    nodes[..., 2] = z[:, None, None] + depth * normal[1][:, None, None]
    return grid_cells(nodes)


def make_crawler(folder: Path) -> list[str]:
    """Write the mesh into a folder; returns lines about it."""
    return [write_mesh(folder / "crawler.vtu", *crawler_cells(CrawlerShape()))]
