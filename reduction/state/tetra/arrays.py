"""What the kernels of a reduced robot read, and their workspace.

Elements are in blocks of LANES: an array over a block holds one number of each of them in a row, so that the
loops over it are of constant length and become vector instructions. Lanes past the last element have no
volume. Tuples, because kernels accept these directly.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.model.numerics import LANES, Array, Ints
from tauten.reduction.state.tetra.product import ROWS


class Body(NamedTuple):
    """Sampled elements, s in b blocks of LANES.

    Attributes:
        elements: s.
        rows: of Z and Y that an element contributes.
        gradient: (b, r, 9 LANES) G, the change of F_ij of a block's elements from (3 i + j) LANES on.
        volume: (b, LANES) weighted volumes w V [m³].
        kind: (b LANES,) density of each element's law.
        constants: (b LANES, 5) constants of its law [Pa].
        lame: (b, 2 LANES) w V λ and w V μ of corotational laws, else zero [N m].
        corotational: whether all laws are corotational.
        turns: whether any is, and needs the rotations of F.
        stiffness: (r, r) Σ 2 μ w V GᵀG where they are, else zero.
        drift: (r,) Σ 2 μ w V Gᵀ I where they are, else zero.
    """

    elements: int
    rows: int
    gradient: Array
    volume: Array
    kind: Ints
    constants: Array
    lame: Array
    corotational: bool
    turns: bool
    stiffness: Array
    drift: Array


class Tendons(NamedTuple):
    """Cable segments, g in the order of their cables: x of all of them in a row, then y, then z.

    Attributes:
        starts: (n_a + 1,) first segment of each cable.
        map: (r, 3 g) Dᵀ, change of the differences of their stations.
        rest: (3 g,) d₀ [m].
        shortest: (g,) distance of the ends below which the length is rounded [m].
    """

    starts: Ints
    map: Array
    rest: Array
    shortest: Array


class Work(NamedTuple):
    """Workspace of the kernels, allocated once.

    Attributes:
        Z, Y: rows that elements and then cables contribute and their images, as columns: (r, z) with zeros up
            to multiples of ROWS and LANES. Those of a block of elements follow each other, LANES columns for
            each row. Columns of Z that do not change, D and those of laws that are not corotational, are
            written once.
        lower: (r, r) lower triangle of the product of Z and Y, zeros included.
        force: (r,) [N].
        K: (r, r) tangent [N/m].
        D: (r, r) stiffness of the material [N/m]; zero without damping.
        curvature: (r, r) what chambers add to an exact tangent [N/m], set before a call.
        L: (r, r) its Cholesky factor.
        v_free: (r,) [m/s].
    """

    Z: Array
    Y: Array
    lower: Array
    force: Array
    K: Array
    D: Array
    curvature: Array
    L: Array
    v_free: Array


def in_lanes(values: Array) -> Array:
    """Numbers of elements (s, m) in blocks: (b, m LANES), zero past the last one."""
    blocks = -(-len(values) // LANES)
    padded = np.zeros((blocks * LANES, values.shape[1]))
    padded[: len(values)] = values
    lanes: Array = padded.reshape(blocks, LANES, -1).swapaxes(1, 2).reshape(blocks, -1)
    return lanes


def make_work(body: Body, tendons: Tendons) -> Work:
    """A workspace for these elements and cables."""
    blocks, r, _ = body.gradient.shape
    first, segments = body.rows * LANES * blocks, tendons.map.shape[1]
    shape = -(-r // ROWS) * ROWS, -(-(first + segments) // LANES) * LANES
    Z = np.zeros(shape)
    if not body.corotational:
        Z[:r, :first] = body.gradient.swapaxes(0, 1).reshape(r, first)
    Z[:r, first : first + segments] = tendons.map
    return Work(
        Z=Z,
        Y=np.zeros(shape),
        lower=np.zeros((shape[0], shape[0])),
        force=np.empty(r),
        K=np.empty((r, r)),
        D=np.zeros((r, r)),
        curvature=np.zeros((r, r)),
        L=np.zeros((r, r)),
        v_free=np.empty(r),
    )
