"""Makes finger.vtu: a hanging finger of blocks joined by V-notch articulations.

    python -m tauten.model.robots.make_finger [FOLDER]

The finger hangs along −z from its fixed face at z = 0, is 15 mm wide in y and bends towards +x, the
side on which the notches open. It is a mapped grid: at a notch plane the grid lines of both
neighbours part above the root of the V.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from itertools import permutations
from pathlib import Path

import meshio
import numpy as np

from tauten.model.mesh import oriented
from tauten.model.numerics import Array, Ints


@dataclass(frozen=True, slots=True)
class FingerShape:
    """Dimensions [m] and grid of the finger.

    Attributes:
        length: along −z.
        width: in y.
        height: in x, the direction it bends to.
        ligament: height of the material that joins two blocks.
        opening: width of a notch at its mouth.
        blocks: blocks; notches are one fewer.
        along: cells along one block.
        across: cells over the width, even so that the mesh is its own mirror image.
        below: cells over the ligament.
        above: cells from the ligament to the top.
    """

    length: float = 0.100
    width: float = 0.015
    height: float = 0.015
    ligament: float = 0.005
    opening: float = 0.003
    blocks: int = 6
    along: int = 4
    across: int = 4
    below: int = 2
    above: int = 3


def make_finger(shape: FingerShape) -> tuple[Array, Ints]:
    """Nodes (n_nodes, 3) [m] and tetrahedra (e, 4) of the finger."""
    x = np.concatenate(
        [
            np.linspace(0.0, shape.ligament, shape.below + 1),
            np.linspace(shape.ligament, shape.height, shape.above + 1)[1:],
        ]
    )
    y = np.linspace(0.0, shape.width, shape.across + 1)
    pitch = shape.length / shape.blocks
    # half the notch's width at each height, zero over the ligament
    gap = (
        0.5 * shape.opening * np.maximum(x - shape.ligament, 0.0) / (shape.height - shape.ligament)
    )
    nodes, cells = [], []
    grid_shape = (shape.along + 1, len(y), len(x))
    for block in range(shape.blocks):
        left = block * pitch + (gap if block > 0 else 0.0 * gap)
        right = (block + 1) * pitch - (gap if block < shape.blocks - 1 else 0.0 * gap)
        u = np.linspace(0.0, 1.0, shape.along + 1)[:, None, None]
        s = np.broadcast_to(left + u * (right - left), grid_shape)
        X, Y = np.broadcast_to(x, grid_shape), np.broadcast_to(y[:, None], grid_shape)
        numbers = np.arange(s.size).reshape(grid_shape) + block * s.size
        nodes.append(np.stack([X, Y, -s], axis=-1).reshape(-1, 3))
        cells.append(split_cells(numbers, mirror_from=shape.across // 2))
    # blocks share the nodes of their ligaments: merge what coincides
    points = np.concatenate(nodes)
    _, first, inverse = np.unique(
        np.round(points, 9), axis=0, return_index=True, return_inverse=True
    )
    merged = points[first]
    return merged, oriented(merged, inverse.ravel()[np.concatenate(cells)])


def split_cells(numbers: Ints, mirror_from: int) -> Ints:
    """Six tetrahedra a cell (Kuhn), mirrored in y from one layer on: (e, 4)."""
    i, j, k = np.meshgrid(*(np.arange(m - 1) for m in numbers.shape), indexing="ij")
    cell = np.stack([i.ravel(), j.ravel(), k.ravel()], axis=1)  # (c, 3)
    tets = []
    for order in permutations(range(3)):
        corner = np.zeros((4, 3), dtype=np.int64)
        for step, axis in enumerate(order):
            corner[step + 1 :, axis] = 1
        corners = np.broadcast_to(corner, (len(cell), 4, 3)).copy()
        mirrored = cell[:, 1] >= mirror_from
        corners[mirrored, :, 1] = 1 - corners[mirrored, :, 1]
        index = cell[:, None, :] + corners
        tets.append(numbers[index[..., 0], index[..., 1], index[..., 2]])
    return np.concatenate(tets)


def main() -> None:
    """Write finger.vtu into the folder given, by default beside this script."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    nodes, tets = make_finger(FingerShape())
    path = folder / "finger.vtu"
    meshio.write(path, meshio.Mesh(nodes, [("tetra", tets)]))
    print(f"{path}: {len(nodes)} nodes, {len(tets)} tetrahedra")


if __name__ == "__main__":
    main()
