"""Which candidates are near a triangle: candidates sorted into the cells of a uniform grid."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.model.arrays import Array, Ints
from tauten.model.jit import kernel
from tauten.model.vector import Vector3, row

CELLS_PER_POINT = 4  # of the whole box; points on a surface fill few of them


class Grid(NamedTuple):
    """Points by cell of a uniform grid over their box; a tuple because kernels take it as it is.

    Attributes:
        lower: (3,) corner of the box [m], +inf when no point is finite.
        upper: (3,) opposite corner [m].
        size: edge of a cell [m].
        shape: cells along each axis.
        start: (cells + 1,) where each cell's points start in `order`.
        order: (f,) numbers of the finite points, cell by cell, ascending in each.
        points: (f, 3) the points in this order.
    """

    lower: Array
    upper: Array
    size: float
    shape: tuple[int, int, int]
    start: Ints
    order: Ints
    points: Array


@kernel
def is_finite(p: Vector3) -> bool:
    """Whether no coordinate is NaN or infinite; by comparison, since sums may be reordered."""
    return abs(p[0]) < np.inf and abs(p[1]) < np.inf and abs(p[2]) < np.inf


@kernel
def make_grid(points: Array, reach: float) -> Grid:
    """Sort points (m, 3) into cells of edge `reach`, or larger where those would be too many."""
    lower, upper = np.full(3, np.inf), np.full(3, -np.inf)
    finite = np.zeros(points.shape[0], np.bool_)
    for s in range(points.shape[0]):
        finite[s] = is_finite(row(points, s))
        for i in range(3):
            if finite[s]:
                lower[i] = min(lower[i], points[s, i])
                upper[i] = max(upper[i], points[s, i])
    size = reach
    extent = np.maximum(upper - lower, 0.0)
    while np.prod(np.floor(extent / size) + 1.0) > CELLS_PER_POINT * points.shape[0] + 64.0:
        size *= 1.25
    shape = (int(extent[0] / size) + 1, int(extent[1] / size) + 1, int(extent[2] / size) + 1)
    cell = np.zeros(points.shape[0], np.int64)
    start = np.zeros(shape[0] * shape[1] * shape[2] + 1, np.int64)
    for s in range(points.shape[0]):
        if finite[s]:
            i = cell_of(points[s, 0], lower[0], size, shape[0])
            j = cell_of(points[s, 1], lower[1], size, shape[1])
            k = cell_of(points[s, 2], lower[2], size, shape[2])
            cell[s] = (i * shape[1] + j) * shape[2] + k
            start[cell[s] + 1] += 1
    start = np.cumsum(start)
    place, order = start.copy(), np.empty(start[-1], np.int64)
    for s in range(points.shape[0]):
        if finite[s]:
            order[place[cell[s]]] = s
            place[cell[s]] += 1
    return Grid(lower, upper, size, shape, start, order, points[order])


@kernel
def cell_of(value: float, lower: float, size: float, cells: int) -> int:
    """Number of the cell a coordinate lies in, moved into the grid from outside."""
    return int(min(max((value - lower) / size, 0.0), cells - 1.0))


@kernel
def triangle_box(a: Vector3, b: Vector3, c: Vector3, reach: float) -> tuple[Vector3, Vector3]:
    """Corners of the triangle's box, widened by `reach`."""
    lower = (
        min(a[0], b[0], c[0]) - reach,
        min(a[1], b[1], c[1]) - reach,
        min(a[2], b[2], c[2]) - reach,
    )
    upper = (
        max(a[0], b[0], c[0]) + reach,
        max(a[1], b[1], c[1]) + reach,
        max(a[2], b[2], c[2]) + reach,
    )
    return lower, upper
