"""Makes finger.vtu: a hanging finger of blocks joined by elastic hinges.

    python -m benchmarks.robots.make_finger [FOLDER] [--across N] [--coarse]

The finger hangs along −z from its fixed face at z = 0, is 15 mm wide in y and bends towards +x, the
side on which the notches open. It is a mapped grid, graded towards the hinges, the fixed face and the ends of
the flanks. A notch has a bevelled root, because strain at a sharp one has no limit as the mesh is refined,
and flanks that meet face to face: where they are farther apart than the root, they point to the centre of
rotation of the hinge.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from itertools import permutations
from pathlib import Path

import meshio
import numpy as np

from tauten.model.load import shipped_folder
from tauten.model.mesh import oriented
from tauten.model.numerics import Array, Ints


@dataclass(frozen=True, slots=True)
class FingerShape:
    """Dimensions [m] and grid of the finger.

    Shares count from 0 at one end of a part to 1 at the other.

    Attributes:
        length: along −z.
        width: in y.
        ligament: height of a hinge below the root of its notch, in x.
        root: half width of a notch at its root.
        slope: of the flanks where they meet, half the angle of rotation that closes a notch [rad].
        pivot: height about which a hinge rotates.
        bevel: height of the bevels of the root, as a share of `root`.
        blocks: blocks; notches are one fewer.
        insert: where the stiff insert at the tip begins, as a distance from the fixed face.
        below: heights over the hinge, as shares.
        root_cells: cells of the flat part of a root and of each bevel.
        above: heights of the nodes of the flanks; the last is the height of the finger.
        across: cells over the width, even so that the mesh is its own mirror image.
        along: nodes along a block, as shares.
        first: the same of the fixed block.
        last: the same of the last block, from its notch to the insert.
        end: cells along the insert.
    """

    length: float = 0.100
    width: float = 0.015
    ligament: float = 0.005
    root: float = 0.0009
    slope: float = 0.12
    pivot: float = 0.0025
    bevel: float = 0.6
    blocks: int = 6
    insert: float = 0.090
    below: tuple[float, ...] = (0.0, 0.45, 0.73, 0.9, 1.0)
    root_cells: int = 1
    above: tuple[float, ...] = (0.0078, 0.0092, 0.010, 0.0108, 0.0125, 0.0142, 0.015)
    across: int = 4
    along: tuple[float, ...] = (0.0, 0.1, 0.25, 0.42, 0.58, 0.75, 0.9, 1.0)
    first: tuple[float, ...] = (0.0, 0.12, 0.3, 0.5, 0.7, 0.85, 0.95, 1.0)
    last: tuple[float, ...] = (0.0, 0.1, 0.3, 0.6, 1.0)
    end: int = 2


# few, large cells, which can be refined more than once
COARSE = FingerShape(
    below=(0.0, 0.6, 1.0),
    above=(0.010, 0.0125, 0.015),
    across=2,
    along=(0.0, 0.5, 1.0),
    first=(0.0, 0.5, 1.0),
    last=(0.0, 0.5, 1.0),
    end=1,
)


def make_finger(shape: FingerShape) -> tuple[Array, Ints]:
    """Nodes (n_nodes, 3) [m] and tetrahedra (e, 4) of the finger."""
    below = np.array(shape.below)
    shoulder = shape.ligament + shape.bevel * shape.root
    x = np.concatenate([shoulder * below, shape.above])
    gap = np.maximum(shape.root, shape.slope * (x - shape.pivot))
    pitch = shape.length / shape.blocks
    # where a hinge has nodes, and its height there: bevels beside a flat root
    corners = np.arange(4.0)
    columns = np.linspace(0.0, 3.0, 3 * shape.root_cells + 1)
    offsets = shape.root * np.interp(columns, corners, [-1.0, -0.4, 0.4, 1.0])
    tops = np.interp(columns, corners, [shoulder, shape.ligament, shape.ligament, shoulder])
    heights = tops[:, None] * below
    layers = []
    for block in range(shape.blocks):
        final = block == shape.blocks - 1
        left = block * pitch + (gap if block > 0 else 0.0 * gap)
        right = np.full(len(x), shape.insert) if final else (block + 1) * pitch - gap
        shares = shape.first if block == 0 else shape.last if final else shape.along
        s = left + np.array(shares)[:, None] * (right - left)  # distances from the fixed face
        if final:
            beyond = np.linspace(shape.insert, shape.length, shape.end + 1)[1:]
            s = np.concatenate([s, np.broadcast_to(beyond[:, None], (shape.end, len(x)))])
        layers.append((np.broadcast_to(x, s.shape), s))
        if not final:
            hinge = (block + 1) * pitch + offsets
            layers.append((heights, np.broadcast_to(hinge[:, None], heights.shape)))
    y = np.linspace(0.0, shape.width, shape.across + 1)
    nodes, cells, count = [], [], 0
    for heights_of, distances in layers:
        size = (distances.shape[0], len(y), distances.shape[1])
        X, S = (np.broadcast_to(item[:, None], size) for item in (heights_of, distances))
        Y = np.broadcast_to(y[:, None], size)
        nodes.append(np.stack([X, Y, -S], axis=-1).reshape(-1, 3))
        numbers = np.arange(X.size).reshape(size) + count
        cells.append(split_cells(numbers, mirror_from=shape.across // 2))
        count += X.size
    # blocks and hinges share the nodes between them: merge what coincides
    points = np.concatenate(nodes)
    _, first, inverse = np.unique(
        np.round(points, 9), axis=0, return_index=True, return_inverse=True
    )
    merged = points[first] + 0.0  # no negative zeros
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
    """Write finger.vtu into a folder."""
    parser = argparse.ArgumentParser(description="Write finger.vtu into a folder.")
    parser.add_argument("folder", type=Path, nargs="?", default=shipped_folder())
    parser.add_argument("--across", type=int, help="cells over the width")
    parser.add_argument("--coarse", action="store_true", help="few, large cells")
    settings = parser.parse_args()
    shape = COARSE if settings.coarse else FingerShape()
    if settings.across is not None:
        shape = replace(shape, across=settings.across)
    nodes, tets = make_finger(shape)
    path = settings.folder / "finger.vtu"
    path.parent.mkdir(parents=True, exist_ok=True)
    meshio.write(path, meshio.Mesh(nodes, [("tetra", tets)]))
    print(f"{path}: {len(nodes)} nodes, {len(tets)} tetrahedra")


if __name__ == "__main__":
    main()
