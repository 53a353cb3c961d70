"""Effectors: points of the body that are to reach targets."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from tauten.model.numerics import Array, Ints
from tauten.model.points.material_points import MaterialPoints
from tauten.model.rows import Rows


def effector_matrix(points: MaterialPoints, dof: Ints, n: int) -> sp.csr_array:
    """H_e of material points, which is constant: (3 p, n).

    Args:
        points: p material points.
        dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
        n: number of degrees of freedom.
    """
    columns = dof[points.nodes]  # (p, 4)
    row = np.broadcast_to(3 * np.arange(len(points))[:, None], columns.shape)
    free = columns >= 0
    parts = [
        sp.coo_array(
            (points.weights[free], (row[free] + i, columns[free] + i)), shape=(3 * len(points), n)
        )
        for i in range(3)
    ]
    return sp.csr_array(sum(parts[1:], start=parts[0]))


def effector_rows(points: MaterialPoints, H: sp.csr_array, x: Array) -> Rows:
    """Positions x_e of the effectors as rows; the controller subtracts the target.

    Args:
        points: (p) material points.
        H: (3 p, n) from `effector_matrix`.
        x: (n_nodes, 3) node positions [m].
    """
    return Rows(H, points.positions(x).ravel())
