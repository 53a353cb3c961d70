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


class SampledElements(NamedTuple):
    """Sampled elements, s in b blocks of LANES, and r modes. R is r up to a multiple of ROWS.

    Attributes:
        elements: s.
        gradient: (b, R, 9 LANES) G, the change of F_ij of a block's elements from (3 i + j) LANES on; zero
            from row r on.
        volume: (b, LANES) weighted volumes w V [m³].
        kind: (b LANES,) density of each element's law.
        constants: (b LANES, 7) constants of its law, λ and μ [Pa].
        lame: (b, 2 LANES) w V λ and w V μ [N m].
        corotational: whether all laws are corotational.
        turns: whether any is, and needs the rotations of F.
        stiffness: (r, r) Σ 2 μ w V GᵀG where all are corotational, else zero.
    """

    elements: int
    gradient: Array
    volume: Array
    kind: Ints
    constants: Array
    lame: Array
    corotational: bool
    turns: bool
    stiffness: Array


class Tendons(NamedTuple):
    """Cable segments, g in the order of their cables: x of all of them in a row, then y, then z.

    Attributes:
        starts: (n_a + 1,) first segment of each cable.
        map: (R, 3 g) Dᵀ, change of the differences of their stations; zero from row r on.
        rest: (3 g,) d₀ [m].
        shortest: (g,) distance of the ends below which the length is rounded [m].
    """

    starts: Ints
    map: Array
    rest: Array
    shortest: Array


class Response(NamedTuple):
    """What the elements answer at a state, and what chambers add to a tangent there.

    Attributes:
        force: (r,) without actuators and contacts [N].
        resisting: (r,) D v [N/s].
        carried: (b, 9 LANES) what carries the stiffness of the material along: rotations of F of corotational
            laws, F of others.
        exact: of the exact tangent, times the volume [N m]: (b, 6 LANES) symmetric matrices of corotational
            laws, (b, 81 LANES) of others.
        semidefinite: of the tangent that is nearest to the exact one and positive semidefinite: (b, 81 LANES)
            where not all laws are corotational [N m]; written by `assemble_semidefinite`.
        curvature: (k, k) what chambers add to an exact tangent [N/m].
    """

    force: Array
    resisting: Array
    carried: Array
    exact: Array
    semidefinite: Array
    curvature: Array


class Work(NamedTuple):
    """Workspace of the kernels, allocated once.

    Attributes:
        response: at the state that was assembled last.
        Z, Y: (R, 4 LANES) or (R, 9 LANES) rows that a block of elements contributes and their images, as
            columns, LANES for each row; zero from row r on. Z is that of corotational laws.
        segments: (R, 3 g) images of the rows of the cable segments.
        lower: (R', R') lower triangle of the sum of products of rows and images, as large as the map of the
            cables.
        S: (k, k) a sum of tangents, for all that elements, cables and chambers depend on [N/m].
        L: (k, k) Cholesky factor of the last system.
    """

    response: Response
    Z: Array
    Y: Array
    segments: Array
    lower: Array
    S: Array
    L: Array


def in_lanes(values: Array) -> Array:
    """Numbers of elements (s, m) in blocks: (b, m LANES), zero past the last one."""
    blocks = -(-len(values) // LANES)
    padded = np.zeros((blocks * LANES, values.shape[1]))
    padded[: len(values)] = values
    lanes: Array = padded.reshape(blocks, LANES, -1).swapaxes(1, 2).reshape(blocks, -1)
    return lanes


def in_rows(values: Array) -> Array:
    """Rows (…, r, m) with rows of zeros up to a multiple of ROWS: (…, R, m)."""
    *others, r, m = values.shape
    padded = np.zeros((*others, -(-r // ROWS) * ROWS, m))
    padded[..., :r, :] = values
    return padded


def make_work(body: SampledElements, tendons: Tendons, size: int) -> Work:
    """A workspace for these elements and cables."""
    blocks, R, _ = body.gradient.shape
    r, rows, entries = len(body.stiffness), 9, 81
    if body.corotational:
        rows, entries = 4, 6
    response = Response(
        force=np.zeros(r),
        resisting=np.zeros(r),
        carried=np.zeros((blocks, 9 * LANES)),
        exact=np.zeros((blocks, entries * LANES)),
        semidefinite=np.zeros((0 if body.corotational else blocks, entries * LANES)),
        curvature=np.zeros((size, size)),
    )
    return Work(
        response=response,
        Z=np.zeros((R, rows * LANES)),
        Y=np.zeros((R, rows * LANES)),
        segments=np.zeros_like(tendons.map),
        lower=np.zeros((len(tendons.map), len(tendons.map))),
        S=np.zeros((size, size)),
        L=np.zeros((size, size)),
    )
