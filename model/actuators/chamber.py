"""Chambers: closed surfaces in or on the body under pressure.

The volume of a closed surface is a sum over its triangles, seen from outside counter-clockwise,

    V(x) = 1/6 Σ y_a · (y_b x y_c)                                                          (A1)

δ = V − V(rest), H = ∂V/∂x. A corner y = Σ w_i x_i is a node of the body, or a point of one of its elements.

A face of a quadratic element bulges between its nodes. By Simpson's rule its volume is (4 V₄ − V₁) / 3, with
V₄ of its four triangles and V₁ of that of its corners: exact to first order in the displacement, so that a
pressure acts on the nodes as the shape functions say. Weights of a triangle that are ∛s as large make its
volume s times as large.
Since the area vectors of the triangles turn and grow with the body, a pressure λ adds −λ ∂²V/∂x² to the
tangent: symmetric for a closed surface, and indefinite.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tauten.model.numerics import Array, Ints, kernel
from tauten.model.points import Entries, NodePoints, Placed
from tauten.model.rows import Rows


@dataclass(frozen=True, slots=True)
class ChamberSurface:
    """The surface of a chamber.

    Attributes:
        triangles: (t, 3) nodes of the body, or numbers of `points`; normals out of the chamber.
        points: points of the body that the triangles join; None: they join nodes.
        faces: (f, 3) corners of the faces of quadratic elements that the triangles are parts of; none where
            they are flat.
    """

    triangles: Ints
    points: NodePoints | None = None
    faces: Ints = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))

    @property
    def corner_nodes(self) -> int:
        """Nodes that a corner of a triangle may depend on."""
        return 1 if self.points is None else self.points.nodes.shape[1]

    def corners(self, count: int) -> tuple[Ints, Array]:
        """Nodes and weights of the corners, each (t + f, 3 count); a corner has at most `count` of them."""
        triangles, scale = bulging(self.triangles, self.faces)
        nodes, weights = triangles[:, :, None], np.tile(scale[:, None, None], (1, 3, 1))
        if self.points is not None:
            nodes, weights = self.points.nodes[self.triangles], self.points.weights[self.triangles]
        missing = count - nodes.shape[2]
        nodes = np.concatenate([nodes, np.repeat(nodes[:, :, :1], missing, axis=2)], axis=2)
        weights = np.pad(weights, ((0, 0), (0, 0), (0, missing)))
        t = len(nodes)
        return nodes.reshape(t, -1).astype(np.int64), weights.reshape(t, -1)


@dataclass(frozen=True, slots=True)
class ChamberSet:
    """All chambers of a robot as arrays for the kernels; a corner of a triangle depends on up to k nodes.

    Attributes:
        owner: (t,) chamber of each triangle.
        nodes: (t, 3 k) nodes of its corners, one corner after the other.
        weights: (t, 3 k) their weights, which sum to one in each corner of a triangle that counts once.
        starts: (c + 1,) where the nodes of each chamber start in `used`.
        used: (s,) nodes that the surfaces depend on, chamber by chamber.
        places: (t, 3 k) places of `nodes` in `used`.
        rest_volume: (c,) V(q₀) [m³].
    """

    owner: Ints
    nodes: Ints
    weights: Array
    starts: Ints
    used: Ints
    places: Ints
    rest_volume: Array

    def __len__(self) -> int:
        return len(self.rest_volume)

    def boundary_triangles(self) -> tuple[Ints, Ints]:
        """Triangles (t, 3) of nodes and the chamber (t,) of each; none where their corners are no nodes."""
        k = self.nodes.shape[1] // 3
        whole = (self.weights[:, ::k] >= 1.0).all(axis=1)
        return self.nodes[whole, ::k], self.owner[whole]

    def corners(self, values: Array, triangles: Ints) -> Array:
        """What nodes have, values (n_nodes, …), at the corners of some triangles (m,): (m, 3, …)."""
        shape = (len(triangles), 3, -1)
        nodes, weights = (part[triangles].reshape(shape) for part in (self.nodes, self.weights))
        at: Array = np.einsum("tck,tck...->tc...", weights, values[nodes])
        return at

    def rows(self, placed: Placed) -> Rows:
        """Changes of volume and ∂V/∂q: Rows of (c, n) [m³]."""
        surface, count = (self.places, self.weights), len(self.used)
        volume, gradient = volumes(placed.y, self.owner, surface, self.places, count)
        H = placed.rows(Entries(self.starts, np.arange(count), gradient))
        return Rows(H, volume[: len(self)] - self.rest_volume)


def bulging(triangles: Ints, faces: Ints) -> tuple[Ints, Array]:
    """Triangles (t + f, 3) of a surface that bulges between its nodes, and the weight of each in its corners.

    Args:
        triangles: (t, 3) of it, normals out of the chamber.
        faces: (f, 3) corners of the faces that they are four parts of each; none: the triangles are flat.
    """
    if len(faces) == 0:
        return triangles, np.ones(len(triangles))
    shares = np.repeat([4.0 / 3.0, -1.0 / 3.0], [len(triangles), len(faces)])
    return np.concatenate([triangles, faces]), np.cbrt(shares)


def make_chambers(surfaces: list[ChamberSurface], x0: Array) -> ChamberSet:
    """Arrays of chambers, each given by its closed surface, with nodes x0 (n_nodes, 3) at rest [m]."""
    k = max((surface.corner_nodes for surface in surfaces), default=1)
    none = np.zeros((0, 3 * k), dtype=np.int64)
    parts = [surface.corners(k) for surface in surfaces]
    owner = np.repeat(np.arange(len(surfaces)), [len(nodes) for nodes, _ in parts]).astype(np.int64)
    nodes = np.concatenate([none, *(nodes for nodes, _ in parts)])
    weights = np.concatenate([np.zeros((0, 3 * k)), *(weights for _, weights in parts)])
    known = [np.unique(nodes) for nodes, _ in parts]
    starts = np.cumsum([0, *(len(part) for part in known)]).astype(np.int64)
    found = [
        start + np.searchsorted(used, part)
        for start, used, (part, _) in zip(starts[:-1], known, parts, strict=True)
    ]
    places = np.concatenate([none, *found]).astype(np.int64)
    used = np.concatenate([np.zeros(0, dtype=np.int64), *known])
    volume, _ = volumes(x0, owner, (nodes, weights), places, len(used))
    return ChamberSet(owner, nodes, weights, starts, used, places, volume[: len(surfaces)])


@kernel
def corners_of(x: Array, nodes: Ints, weights: Array, t: int, y: Array) -> None:
    """Write the corners (3, 3) of a triangle.

    Args:
        x: (n_nodes, 3) node positions [m].
        nodes: (t, 3 k) nodes of the corners.
        weights: (t, 3 k) their weights.
        t: the triangle.
        y: (3, 3) output, a row for each corner [m].
    """
    k = nodes.shape[1] // 3
    for corner in range(3):
        for i in range(3):
            total = 0.0
            for at in range(corner * k, corner * k + k):
                total += weights[t, at] * x[nodes[t, at], i]
            y[corner, i] = total


@kernel
def volumes(
    x: Array, owner: Ints, surface: tuple[Ints, Array], places: Ints, n_places: int
) -> tuple[Array, Array]:
    """Volumes by chamber, at least as many entries as chambers, and ∂V/∂x (n_places, 3) by place.

    Args:
        x: (n_nodes, 3) node positions [m].
        owner: (t,) chamber of each triangle.
        surface: nodes (t, 3 k) of the corners and their weights.
        places: (t, 3 k) places of the nodes in the gradient.
        n_places: number of places.
    """
    nodes, weights = surface
    k = nodes.shape[1] // 3
    volume, gradient = np.zeros(nodes.shape[0]), np.zeros((n_places, 3))
    y = np.empty((3, 3))
    for t in range(nodes.shape[0]):
        corners_of(x, nodes, weights, t, y)
        for first in range(3):
            b, c = (first + 1) % 3, (first + 2) % 3
            g0 = (y[b, 1] * y[c, 2] - y[b, 2] * y[c, 1]) / 6.0
            g1 = (y[b, 2] * y[c, 0] - y[b, 0] * y[c, 2]) / 6.0
            g2 = (y[b, 0] * y[c, 1] - y[b, 1] * y[c, 0]) / 6.0
            for at in range(first * k, first * k + k):
                w, place = weights[t, at], places[t, at]
                gradient[place, 0] += w * g0
                gradient[place, 1] += w * g1
                gradient[place, 2] += w * g2
            if first == 0:
                volume[owner[t]] += y[0, 0] * g0 + y[0, 1] * g1 + y[0, 2] * g2
    return volume, gradient


@kernel
def add_chamber_stiffness(
    x: Array,
    owner: Ints,
    surface: tuple[Ints, Array],
    pressure: Array,
    blocks: tuple[Ints, Ints],
    K: Array,
) -> None:
    """Add −λ ∂²V/∂x² of every triangle to a tangent.

    Args:
        x: (n_nodes, 3) node positions [m].
        owner: (t,) chamber of each triangle.
        surface: nodes (t, 3 k) of the corners and their weights.
        pressure: (c,) [Pa].
        blocks: slot (t, 3 k, 3 k) and column_length (t, 3 k), see `Pattern.blocks`.
        K: (nnz,) CSC values of −∂force, added to.
    """
    nodes, weights = surface
    slot, column_length = blocks
    k = nodes.shape[1] // 3
    y = np.empty((3, 3))
    for t in range(nodes.shape[0]):
        scale = pressure[owner[t]] / 6.0
        if scale == 0.0:
            continue
        corners_of(x, nodes, weights, t, y)
        for a in range(3):
            for turn in range(1, 3):
                b = (a + turn) % 3
                # ∂²V/∂y_a∂y_b = ∓[y_c]x / 6 with the third corner c
                c = (a + 3 - turn) % 3
                sign = scale if turn == 1 else -scale
                c0, c1, c2 = sign * y[c, 0], sign * y[c, 1], sign * y[c, 2]
                for i in range(a * k, a * k + k):
                    for j in range(b * k, b * k + k):
                        w = weights[t, i] * weights[t, j]
                        first, length = slot[t, i, j], column_length[t, j]
                        if first < 0 or w == 0.0:
                            continue
                        K[first + length] -= w * c2  # entry (0, 1)
                        K[first + 2 * length] += w * c1
                        K[first + 1] += w * c2
                        K[first + 2 * length + 1] -= w * c0
                        K[first + 2] -= w * c1
                        K[first + length + 2] += w * c0
