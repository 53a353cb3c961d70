"""Long steps that turn elements instead of stretching them.

A linearised step moves every node along a straight line. Where it turns an element by θ it also stretches
it by about θ²/2, and in a slender body that stretch costs far more energy than the bending the step is for.
Here the step u of the nodes gives each element, F = R S, a rate of its rotation and of its stretch,

    Ḟ = ∇u = R (Ω S + Ṡ),   (tr S I − S) ω = 2 axl(Rᵀ ∇u)                           (R1)

and the displacement whose gradients come closest to R exp(Ω) (S + Ṡ) − F, in the mean square over the
volume at rest, is taken instead. It differs from u in second order, so that Newton's method converges as
before.
(Huang, Tong, Zhou, Bao and Desbrun, Interactive shape interpolation through controllable dynamic deformation,
IEEE Transactions on Visualization and Computer Graphics 17, 2011.)
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array, Ints, kernel, make_factorisation, polar_rotations
from tauten.model.tetra.elements import rest_gradients

SHIFT = 1e-9  # of the Laplacian's diagonal: bodies without fixed nodes are solved too


class TurningSteps:
    """Turns steps of the nodes of a mesh into such that turn its elements."""

    def __init__(self, mesh: TetMesh, dof: Ints) -> None:
        """Factorise the Laplacian of the free nodes, of dof ≥ 0 (n_nodes,), once for a mesh at rest."""
        self._made_of = mesh, dof
        self._tets = np.asarray(mesh.tets, dtype=np.int64)
        self._gradients, self._volumes = rest_gradients(mesh), mesh.volumes
        self._free = dof >= 0
        number = np.where(self._free, np.cumsum(self._free) - 1, -1)[self._tets]  # (e, 4)
        values = np.einsum("e,eai,ebi->eab", self._volumes, self._gradients, self._gradients)
        rows, columns = np.repeat(number, 4, axis=1).ravel(), np.tile(number, (1, 4)).ravel()
        kept, size = (rows >= 0) & (columns >= 0), int(self._free.sum())
        laplacian = sp.csc_array(
            (values.ravel()[kept], (rows[kept], columns[kept])), shape=(size, size)
        )
        laplacian += sp.diags_array(SHIFT * laplacian.diagonal())
        laplacian = sp.csc_array(laplacian)
        laplacian.sort_indices()
        self._factors = make_factorisation(
            laplacian.indptr.astype(np.int64), laplacian.indices.astype(np.int64)
        )
        self._factors.refactor(laplacian.data)

    def __reduce__(self) -> tuple[type[TurningSteps], tuple[TetMesh, Ints]]:
        """A copy factorises again: factors are copied without their numbers."""
        return TurningSteps, self._made_of

    def turned(self, x: Array, u: Array) -> Array:
        """The displacement (n,) of free nodes instead of a straight u (n,), from nodes x (n_nodes, 3) [m]."""
        moves = np.zeros_like(x)
        moves[self._free] = u.reshape(-1, 3)
        B = self._gradients
        F = np.einsum("eai,eaj->eij", x[self._tets], B)
        R = np.empty_like(F)
        polar_rotations(F, R)
        D = np.einsum("eai,eaj->eij", moves[self._tets], B)
        load = np.zeros_like(x)
        add_turns(F, R, D, self._tets, B, self._volumes, load)
        change: Array = u + self._factors.solve(np.asfortranarray(load[self._free])).ravel()
        return change


@kernel
def add_turns(
    F: Array, R: Array, D: Array, tets: Ints, gradients: Array, volumes: Array, load: Array
) -> None:
    """Add V (R exp(Ω) (S + Ṡ) − F − ∇u) ∇₀N of all elements to the load on the nodes.

    Args:
        F: (e, 3, 3) deformation gradients.
        R: (e, 3, 3) their rotations.
        D: (e, 3, 3) gradients of the step at rest.
        tets: (e, 4) node ids.
        gradients: (e, 4, 3) of the shape functions at rest [1/m].
        volumes: (e,) at rest [m³].
        load: (n_nodes, 3), added to.
    """
    identity = np.eye(3)
    for e in range(F.shape[0]):
        rate, S = R[e].T @ D[e], R[e].T @ F[e]
        M = (S[0, 0] + S[1, 1] + S[2, 2]) * identity - S
        cofactors = np.empty((3, 3))
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            for m in range(3):
                p, q = (m + 1) % 3, (m + 2) % 3
                cofactors[i, m] = M[j, p] * M[k, q] - M[j, q] * M[k, p]
        determinant = (
            M[0, 0] * cofactors[0, 0] + M[0, 1] * cofactors[0, 1] + M[0, 2] * cofactors[0, 2]
        )
        if determinant == 0.0:
            continue
        axial = np.array(
            [rate[2, 1] - rate[1, 2], rate[0, 2] - rate[2, 0], rate[1, 0] - rate[0, 1]]
        )
        w = cofactors.T @ axial / determinant  # M⁻¹
        angle = np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
        if not np.isfinite(angle):
            continue
        W = np.zeros((3, 3))
        W[2, 1], W[1, 2] = w[0], -w[0]
        W[0, 2], W[2, 0] = w[1], -w[1]
        W[1, 0], W[0, 1] = w[2], -w[2]
        sine = np.sin(angle) / angle if angle > 1e-8 else 1.0
        half = np.sin(0.5 * angle) / angle if angle > 1e-8 else 0.5
        turn = identity + sine * W + 2.0 * half * half * (W @ W)
        T = volumes[e] * (R[e] @ (turn @ (S + rate - W @ S)) - F[e] - D[e])
        for a in range(4):
            for i in range(3):
                node = tets[e, a]
                load[node, i] += (
                    T[i, 0] * gradients[e, a, 0]
                    + T[i, 1] * gradients[e, a, 1]
                    + T[i, 2] * gradients[e, a, 2]
                )
