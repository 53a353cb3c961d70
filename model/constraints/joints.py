"""What joins frames: beam elements between nodes that are frames, and springs that keep points together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tauten.model.beams import BeamArrays, element
from tauten.model.mesh import TetMesh, boundary_triangles
from tauten.model.numerics import Array, Ints, kernel
from tauten.model.points import AttachedPoints


@dataclass(frozen=True, slots=True)
class FrameJoints:
    """Beams and springs of a robot with constraints.

    Attributes:
        nodes: (b,) the node of the robot at each node of a beam.
        turning: (b,) the region whose rotation it has, −1 where it is fixed.
        beams: elements between these.
        inertia: (b,) lumped rotary inertia [kg m²].
        outline: (P,) points of the beams' lateral surfaces, attached to the b nodes.
        triangles: (t, 3) between these points.
        springs: S (3 s, 3 n_nodes), the square root of their stiffness times the distance between the two
            points of each spring, energy ½ |S x|² [N^½ m^-½].
    """

    nodes: Ints
    turning: Ints
    beams: BeamArrays
    inertia: Array
    outline: AttachedPoints
    triangles: Ints
    springs: sp.csr_array

    def points(self, x: Array, Q: Array) -> Array:
        """All nodes x (n_nodes, 3), then the outlines of beams whose nodes have rotations Q (b, 4) [m]."""
        return np.concatenate([x, self.outline.place(x[self.nodes], Q)[0]])

    def drawn(self, mesh: TetMesh) -> Ints:
        """Triangles of `points`: the boundary of what is no beam, and the surfaces of beams."""
        solid = mesh.tets[~np.isin(mesh.tets, self.nodes).any(axis=1)]
        return np.concatenate([boundary_triangles(solid), self.triangles + len(mesh.nodes)])

    def entries(self, number: Ints) -> tuple[Ints, Ints]:
        """Rows and columns (144 e + links) of the entries of K that `assemble` gives.

        Args:
            number: (n_nodes,) number of each node among the m that are not fixed, −1 where it is fixed.
        """
        m = int(number.max(initial=-1)) + 1
        c = np.arange(3)
        place = np.where(number >= 0, 3 * number, -1)[self.nodes]
        own = 3 * m + 3 * np.arange(len(self.nodes))
        groups = np.stack([place, np.where(self.turning >= 0, own, -1)], axis=1)  # (b, 2)
        first = groups[self.beams.ends].reshape(-1, 4, 1)  # (e, 4, 1)
        rows = np.where(first >= 0, first + c, -1).reshape(-1, 12)  # (e, 12)
        link = self.spring_tangent(number)
        i = np.concatenate([np.repeat(rows, 12, axis=1).ravel(), link.row])
        j = np.concatenate([np.tile(rows, (1, 12)).ravel(), link.col])
        left_out = (i < 0) | (j < 0)
        return np.where(left_out, -1, i), np.where(left_out, -1, j)

    def spring_tangent(self, number: Ints) -> sp.coo_array:
        """SᵀS over the nodes that are not fixed: (3 m, 3 m)."""
        free = (3 * np.flatnonzero(number >= 0)[:, None] + np.arange(3)).ravel()
        S = sp.csr_array(sp.csc_array(self.springs)[:, free])
        return sp.coo_array(S.T @ S)

    def assemble(self, x: Array, Q: Array, exact: bool) -> tuple[float, Array, Array, Array]:
        """Energy [J], forces on all nodes (n_nodes, 3) [N], moments (b, 3) [N m] and K of the beams (144 e,).

        Args:
            x: (n_nodes, 3) positions of all nodes [m].
            Q: (b, 4) rotations of the nodes of beams.
            exact: with the terms of the tangent that stress brings, which may make it indefinite.
        """
        force, K = np.zeros((len(self.nodes), 6)), np.zeros((len(self.beams.ends), 12, 12))
        energy = beam_forces(x[self.nodes], Q, self.beams, exact, force, K)
        on_nodes = np.zeros_like(x)
        np.add.at(on_nodes, self.nodes, force[:, :3])
        stretch = self.springs @ x.ravel()
        on_nodes -= (self.springs.T @ stretch).reshape(-1, 3)
        return energy + 0.5 * float(stretch @ stretch), on_nodes, force[:, 3:], K.ravel()


@kernel
def beam_forces(
    x: Array, Q: Array, beams: BeamArrays, exact: bool, force: Array, K: Array
) -> float:
    """Add forces and moments of all elements to `force`, fill their tangents; returns the energy [J].

    Args:
        x: (b, 3) positions [m].
        Q: (b, 4) rotations, unit quaternions.
        beams: all elements.
        exact: see `element`.
        force: (b, 6) forces [N] and moments [N m], added to.
        K: (e, 12, 12) tangents, filled.
    """
    energy, part = 0.0, np.empty(12)
    for k in range(beams.ends.shape[0]):
        a, b = beams.ends[k]
        energy += element(x, Q, beams, k, exact, part, K[k])
        for i in range(6):
            force[a, i] += part[i]
            force[b, i] += part[6 + i]
    return energy
