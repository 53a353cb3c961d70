"""The displacements of pins of beams as coordinates, and how soft material follows them.

The node of a beam that is pinned is where a weighted mean of nodes of soft material is, W u. In modes alone a
wire would stretch wherever it bends. So the displacements d = W u of the pins are coordinates,

    u = L d + Φ α,   W L = I,   W Φ = 0                                                      (T7)

with the static displacements L of the soft material under unit displacements of the pins, and modes Φ that
leave the pins where they are.

Source: constraint modes and fixed-interface modes, Craig and Bampton, AIAA Journal 6, 1968.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.linalg import qr

from tauten.model.numerics import Array, make_factorisation
from tauten.model.tetra import Tetrahedra

INDEPENDENT = 1e-3  # of the largest pivot, which weights of another pin have
HELD = 1e-8  # inertia that holds what floats, relative to the stiffness


@dataclass(frozen=True, slots=True, eq=False)
class Lifting:
    """Pins and the displacements that follow them.

    Attributes:
        W: (p, k) weights of the k nodes that modes move.
        L: (3 k, 3 p).
    """

    W: sp.csr_array
    L: Array

    def pins(self, u: Array) -> Array:
        """Displacements of the pins (3 p, s) of those of the nodes (3 k, s)."""
        found: Array = (self.W @ u.reshape(self.W.shape[1], -1)).reshape(-1, u.shape[1])
        return found


def make_lifting(
    tetrahedra: Tetrahedra, weights: sp.csr_array, spread: sp.csr_array, solver: str
) -> Lifting | None:
    """Pins whose positions are independent of each other; None: there are none.

    The others, of several in one tetrahedron, are where these take the tetrahedron.

    Args:
        tetrahedra: of the body.
        weights: (p, k) of the nodes that modes move, for each pin.
        spread: (3 n_nodes, 3 k) displacements of all nodes from those of these.
        solver: name of the factorisation.
    """
    if weights.nnz == 0:
        return None
    used = np.unique(weights.indices)
    _, R, pivots = qr(weights[:, used].toarray().T, mode="economic", pivoting=True)
    pivot = np.abs(np.diag(R))
    W = sp.csr_array(weights[np.sort(pivots[: int((pivot > INDEPENDENT * pivot[0]).sum())])])
    rest = tetrahedra.placed(tetrahedra.at_rest)
    _, values = tetrahedra.forces(tetrahedra.elements.semidefinite, rest, None)
    stiff = sp.csc_array(spread.T @ tetrahedra.pattern.matrix(values) @ spread)
    mass = spread.T @ (tetrahedra.mass[:, None] * spread)
    scale = stiff.trace() / mass.trace()
    B = sp.csc_array(sp.kron(W, np.eye(3), format="csc"))
    A = sp.csc_array(stiff + HELD * scale * mass + stiff.trace() / stiff.shape[0] * (B.T @ B))
    A.sort_indices()
    factors = make_factorisation(A.indptr.astype(np.int64), A.indices.astype(np.int64), solver)
    factors.refactor(A.data)
    moved = factors.solve(np.ascontiguousarray(B.T.toarray()))  # (3 k, 3 p)
    return Lifting(W, np.linalg.solve((B @ moved).T, moved.T).T)
