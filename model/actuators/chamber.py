"""Chambers: closed surfaces of the body under pressure.

The volume of a closed surface is a sum over its triangles, seen from outside counter-clockwise,

    V(x) = 1/6 Σ x_a · (x_b x x_c)                                                          (A1)

δ = V − V(rest), H = ∂V/∂x. Since the area vectors of the triangles turn and grow with the body, a pressure λ
adds −λ ∂²V/∂x² to the tangent: symmetric for a closed surface, and indefinite.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tauten.model.numerics import Array, Ints, kernel
from tauten.model.rows import Rows


@dataclass(frozen=True, slots=True)
class ChamberSet:
    """All chambers of a robot as arrays for the kernels.

    Attributes:
        owner: (t,) chamber of each triangle.
        triangles: (t, 3) nodes.
        starts: (c + 1,) where the nodes of each chamber start in `nodes`.
        nodes: (s,) nodes of the surfaces, chamber by chamber.
        corners: (t, 3) places in `nodes`.
        rest_volume: (c,) V(q₀) [m³].
    """

    owner: Ints
    triangles: Ints
    starts: Ints
    nodes: Ints
    corners: Ints
    rest_volume: Array

    def __len__(self) -> int:
        return len(self.rest_volume)

    def rows(self, x: Array, dof: Ints, n: int) -> Rows:
        """Changes of volume and ∂V/∂q: Rows of (c, n) [m³].

        Args:
            x: (n_nodes, 3) node positions [m].
            dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
            n: number of degrees of freedom.
        """
        volume, gradient = volumes(x, self.owner, self.triangles, self.corners, len(self.nodes))
        first = dof[self.nodes]  # (s,)
        free = first >= 0
        columns = (first[free, None] + np.arange(3)).ravel()
        starts = np.concatenate([[0], np.cumsum(3 * free)])[self.starts]
        H = sp.csr_array((gradient[free].ravel(), columns, starts), shape=(len(self), n))
        return Rows(H, volume[: len(self)] - self.rest_volume)


def make_chambers(surfaces: list[Ints], x0: Array) -> ChamberSet:
    """Arrays of the chambers.

    Args:
        surfaces: triangles (t, 3) of each, closed, normals out of the chamber.
        x0: (n_nodes, 3) node positions at rest [m].
    """
    none = np.zeros((0, 3), dtype=np.int64)
    owner = np.repeat(np.arange(len(surfaces)), [len(part) for part in surfaces])
    triangles = np.concatenate([none, *surfaces]).astype(np.int64)
    used = [np.unique(part) for part in surfaces]
    starts = np.cumsum([0, *(len(part) for part in used)]).astype(np.int64)
    corners = [
        start + np.searchsorted(known, part)
        for start, known, part in zip(starts[:-1], used, surfaces, strict=True)
    ]
    places = np.concatenate([none, *corners]).astype(np.int64)
    nodes = np.concatenate([np.zeros(0, dtype=np.int64), *used])
    volume, _ = volumes(x0, owner.astype(np.int64), triangles, places, len(nodes))
    return ChamberSet(
        owner.astype(np.int64), triangles, starts, nodes, places, volume[: len(surfaces)]
    )


@kernel
def volumes(
    x: Array, owner: Ints, triangles: Ints, corners: Ints, n_places: int
) -> tuple[Array, Array]:
    """Volumes by chamber, at least as many entries as chambers, and ∂V/∂x (n_places, 3) by place.

    Args:
        x: (n_nodes, 3) node positions [m].
        owner: (t,) chamber of each triangle.
        triangles: (t, 3) nodes.
        corners: (t, 3) places of the nodes in the gradient.
        n_places: number of places.
    """
    volume, gradient = np.zeros(triangles.shape[0]), np.zeros((n_places, 3))
    for t in range(triangles.shape[0]):
        for first in range(3):
            b, c = triangles[t, (first + 1) % 3], triangles[t, (first + 2) % 3]
            place = corners[t, first]
            g0 = (x[b, 1] * x[c, 2] - x[b, 2] * x[c, 1]) / 6.0
            g1 = (x[b, 2] * x[c, 0] - x[b, 0] * x[c, 2]) / 6.0
            g2 = (x[b, 0] * x[c, 1] - x[b, 1] * x[c, 0]) / 6.0
            gradient[place, 0] += g0
            gradient[place, 1] += g1
            gradient[place, 2] += g2
            if first == 0:
                a = triangles[t, 0]
                volume[owner[t]] += x[a, 0] * g0 + x[a, 1] * g1 + x[a, 2] * g2
    return volume, gradient


@kernel
def add_chamber_stiffness(
    x: Array, owner: Ints, triangles: Ints, pressure: Array, blocks: tuple[Ints, Ints], K: Array
) -> None:
    """Add −λ ∂²V/∂x² of every triangle to a tangent.

    Args:
        x: (n_nodes, 3) node positions [m].
        owner: (t,) chamber of each triangle.
        triangles: (t, 3) nodes.
        pressure: (c,) [Pa].
        blocks: slot (t, 3, 3) and column_length (t, 3), see `Pattern.blocks`.
        K: (nnz,) CSC values of −∂force, added to.
    """
    slot, column_length = blocks
    for t in range(triangles.shape[0]):
        scale = pressure[owner[t]] / 6.0
        if scale == 0.0:
            continue
        for a in range(3):
            for turn in range(1, 3):
                b = (a + turn) % 3
                if slot[t, a, b] < 0:
                    continue
                # ∂²V/∂x_a∂x_b = ∓[x_c]x / 6 with the third corner c
                c = triangles[t, (a + 3 - turn) % 3]
                sign = scale if turn == 1 else -scale
                first, length = slot[t, a, b], column_length[t, b]
                K[first + length] += -sign * x[c, 2]  # entry (0, 1)
                K[first + 2 * length] += sign * x[c, 1]
                K[first + 1] += sign * x[c, 2]
                K[first + 2 * length + 1] += -sign * x[c, 0]
                K[first + 2] += -sign * x[c, 1]
                K[first + length + 2] += sign * x[c, 0]
