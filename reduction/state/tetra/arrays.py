"""What the kernels of a reduced robot read, and their workspace.

Tuples, because kernels accept these directly.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.model.numerics import Array, Ints

ROWS, COLUMNS = 4, 8  # that `symmetric_product` takes at a time


class Body(NamedTuple):
    """Sampled elements.

    Attributes:
        gradient: (9 s, r) G, row 9 e + 3 i + j the change of F_ij of element e.
        volume: (s,) weighted volumes w V [m³].
        kind: (s,) density of each element's law.
        constants: (s, 5) constants of its law, (λ, μ) of a corotational one [Pa].
        corotational: whether all laws are corotational.
        turns: whether any is, and needs the rotations of F.
        stiffness: (r, r) Σ 2 μ w V GᵀG where they are, else zero.
        drift: (r,) Σ 2 μ w V Gᵀ I where they are, else zero.
    """

    gradient: Array
    volume: Array
    kind: Ints
    constants: Array
    corotational: bool
    turns: bool
    stiffness: Array
    drift: Array


class Tendons(NamedTuple):
    """Cable segments.

    Attributes:
        owner: (g,) cable of each segment.
        map: (3 g, r) D, change of the difference of its stations.
        rest: (3 g,) d₀ [m].
        rest_length: (n_a,) [m].
    """

    owner: Ints
    map: Array
    rest: Array
    rest_length: Array


class Work(NamedTuple):
    """Workspace of the kernels, allocated once.

    Attributes:
        F: (s, 3, 3) deformation gradients.
        R: (s, 3, 3) their rotations.
        d: (3 g,) differences of stations.
        Z, Y: (4 s + 3 g, r) rows and their images; with laws that are not corotational
            (9 s + 3 g, r), and Z begins with G. Zeros follow up to a multiple of four rows and of eight
            columns (see `symmetric_product`).
        lower: (r, r) lower triangle of the product of Z and Y, zeros included.
        force: (r,) [N].
        K: (r, r) tangent [N/m].
        curvature: (r, r) what chambers add to an exact tangent [N/m], set before a call.
        L: (r, r) its Cholesky factor.
        v_free: (r,) [m/s].
    """

    F: Array
    R: Array
    d: Array
    Z: Array
    Y: Array
    lower: Array
    force: Array
    K: Array
    curvature: Array
    L: Array
    v_free: Array


def make_work(body: Body, tendons: Tendons) -> Work:
    """A workspace for these elements and cables."""
    rows = 4 if body.corotational else 9  # of an element
    r, z = body.gradient.shape[1], rows * len(body.volume) + len(tendons.rest)
    shape = -(-z // ROWS) * ROWS, -(-r // COLUMNS) * COLUMNS
    Z = np.zeros(shape)
    if not body.corotational:
        Z[: len(body.gradient), :r] = body.gradient
    return Work(
        F=np.empty((len(body.volume), 3, 3)),
        R=np.empty((len(body.volume), 3, 3)),
        d=np.empty(len(tendons.rest)),
        Z=Z,
        Y=np.zeros(shape),
        lower=np.zeros((shape[1], shape[1])),
        force=np.empty(r),
        K=np.empty((r, r)),
        curvature=np.zeros((r, r)),
        L=np.zeros((r, r)),
        v_free=np.empty(r),
    )
