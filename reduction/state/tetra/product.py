"""The product of two matrices that is known to be symmetric: half the operations of a general one."""

from __future__ import annotations

from tauten.model.numerics import Array, kernel

ROWS = 4  # of Z that are multiplied with two of Y at a time: eight sums fit into the registers


@kernel
def add_symmetric_product(Z: Array, Y: Array, lower: Array) -> None:
    """Add the lower triangle of Z Yᵀ, and some entries above it.

    Args:
        Z: (n, z), n a multiple of ROWS.
        Y: (n, z).
        lower: (n, n) added to.
    """
    for i in range(0, Z.shape[0], ROWS):
        z0, z1, z2, z3 = Z[i], Z[i + 1], Z[i + 2], Z[i + 3]
        for j in range(0, i + ROWS, 2):
            y0, y1 = Y[j], Y[j + 1]
            s00 = s01 = s10 = s11 = s20 = s21 = s30 = s31 = 0.0
            for k in range(z0.shape[0]):
                s00, s01 = s00 + z0[k] * y0[k], s01 + z0[k] * y1[k]
                s10, s11 = s10 + z1[k] * y0[k], s11 + z1[k] * y1[k]
                s20, s21 = s20 + z2[k] * y0[k], s21 + z2[k] * y1[k]
                s30, s31 = s30 + z3[k] * y0[k], s31 + z3[k] * y1[k]
            lower[i, j] += s00
            lower[i, j + 1] += s01
            lower[i + 1, j] += s10
            lower[i + 1, j + 1] += s11
            lower[i + 2, j] += s20
            lower[i + 2, j + 1] += s21
            lower[i + 3, j] += s30
            lower[i + 3, j + 1] += s31
